# SPDX-License-Identifier: Apache-2.0
"""The tires that a plan may name: their limits, and their names in the simulated plant."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from flatplank_analysis.models.tire_record import TireRecord, read_record, shipped_record
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import load_yaml
from flatplank_hw.share import config_file

FILE = "tires.yaml"
OF_THE_RECORD = ("free_radius", "nominal_load", "nominal_pressure")
"""keys that an entry without `record` must have"""


@dataclass(frozen=True)
class TireEntry:
    """One tire of the lab."""

    name: str
    plant: str
    """name of the simulated tire; empty: none"""
    record: TireRecord
    max_load: float
    """largest load [N]"""
    pressure_range: tuple[float, float]
    """lowest and highest pressure [bar]"""
    effective_rolling_radius: float = math.nan
    """at nominal load and pressure [m]; NaN: unknown"""

    @property
    def free_radius(self) -> float:
        """Free radius r_0 [m]."""
        return self.record.free_radius

    @property
    def nominal_load(self) -> float:
        """Nominal load F_z0 [N]."""
        return self.record.nominal_load

    @property
    def nominal_pressure(self) -> float:
        """Nominal pressure p_0 [bar]."""
        return self.record.nominal_pressure


def known_tires(more: Path | None = None) -> dict[str, TireEntry]:
    """Tires of the packaged list and of a file of the lab in the same format."""
    packaged = config_file("flatplank_control", FILE)
    if packaged is None:
        raise ValueError(f"{FILE}: not found; build the workspace")
    found = _read(packaged)
    return found | _read(more) if more else found


def tire_of_plant(plant: str) -> TireEntry | None:
    """The tire with this name in the simulated plant."""
    return next((t for t in known_tires().values() if t.plant == plant), None)


def _read(path: Path) -> dict[str, TireEntry]:
    data = load_yaml(path.read_bytes(), path) or {}
    return {name: _entry(name, values, path) for name, values in data.items()}


def _entry(name: str, values: dict[str, Any], path: Path) -> TireEntry:
    known = {f.name for f in fields(TireEntry)} - {"name"}
    for key in values:
        if key not in known.union(OF_THE_RECORD):
            raise ValueError(f"{path}: {name}: unknown key '{key}'{nearest_hint(key, known)}")
    needed = {"plant", "max_load", "pressure_range"}
    needed |= {"record"} if "record" in values else set(OF_THE_RECORD)
    missing = sorted(needed - set(values))
    if missing:
        raise ValueError(f"{path}: {name}: {', '.join(missing)} missing")
    low, high = values["pressure_range"]
    own = {k: v for k, v in values.items() if k in known}
    own |= {"record": _record(name, values, path), "pressure_range": (float(low), float(high))}
    return TireEntry(name=name, **own)


def _record(name: str, values: dict[str, Any], path: Path) -> TireRecord:
    if "record" not in values:
        radius, load, pressure = (float(values[key]) for key in OF_THE_RECORD)
        return TireRecord(name, radius, load, pressure, origin=str(path))
    file = path.parent / str(values["record"])
    record = read_record(file) if file.is_file() else shipped_record(str(values["record"]))
    return dataclasses.replace(record, name=name)
