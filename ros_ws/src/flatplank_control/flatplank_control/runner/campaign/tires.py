# SPDX-License-Identifier: Apache-2.0
"""The tires that a plan may name: what they stand, and what the simulated plant calls them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import yaml

from flatplank_hw.params import nearest
from flatplank_hw.share import config_file

FILE = "tires.yaml"


@dataclass(frozen=True)
class TireEntry:
    """One tire of the lab."""

    name: str
    plant: str
    """name of the simulated tire; empty: none"""
    free_radius: float
    """[m]"""
    nominal_load: float
    """F_z0 [N]"""
    nominal_pressure: float
    """p_0 [bar]"""
    max_load: float
    """[N]"""
    pressure_range: tuple[float, float]
    """[bar]"""


def known_tires(more: Path | None = None) -> dict[str, TireEntry]:
    """Tires of the packaged list, then those of a lab's own file in the same form."""
    packaged = config_file("flatplank_control", FILE)
    if packaged is None:
        raise ValueError(f"{FILE}: not found; build the workspace")
    found = _read(packaged)
    return found | _read(more) if more else found


def _read(path: Path) -> dict[str, TireEntry]:
    data = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    return {name: _entry(name, values, path) for name, values in data.items()}


def _entry(name: str, values: dict[str, Any], path: Path) -> TireEntry:
    known = {f.name for f in fields(TireEntry)} - {"name"}
    for key in values:
        if key not in known:
            raise ValueError(f"{path}: {name}: unknown key '{key}'{nearest(key, known)}")
    missing = sorted(known - set(values))
    if missing:
        raise ValueError(f"{path}: {name}: {', '.join(missing)} missing")
    low, high = values["pressure_range"]
    return TireEntry(name=name, **{**values, "pressure_range": (float(low), float(high))})
