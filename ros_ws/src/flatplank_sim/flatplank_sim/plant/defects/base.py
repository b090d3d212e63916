# SPDX-License-Identifier: Apache-2.0
"""Base class of the defects of the machine, and the records that they change."""

from __future__ import annotations

import importlib
import math
import pkgutil
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from flatplank_data.names import nearest_hint
from flatplank_data.params import ParameterError, from_mapping, validate
from flatplank_sim.plant.layout import MAP_START, MAP_STEP

_DEFECTS: dict[str, type[Defect]] = {}


class Site(NamedTuple):
    """Records of layout.py that a defect can change."""

    machine: np.ndarray
    tire: np.ndarray
    wheel_servo: np.ndarray
    road_map: np.ndarray
    """over plank position: friction factor, height of the plank [m], height of a cleat [m], error
    of the travel in this run [m]"""
    mix: np.ndarray
    """matrix from true to measured (Fx, Fy, Fz, Mx, Mz) at the wheel centre"""
    drift: np.ndarray
    """C1..C6: offset [V], drift [V/s]; last row LVDT: offset [V], gain error"""

    def positions(self) -> np.ndarray:
        """Road positions of the rows of the map, zero at the motion trigger [m]."""
        x = np.arange(len(self.road_map)) * MAP_STEP - MAP_START
        return x - float(self.machine["trigger_at"][0])

    def use_map(self) -> None:
        """Enable the road map; the road is no longer uniform."""
        self.machine["mapped"] = 1


def defect_param(
    default: Any,
    unit: str,
    note: str,
    bounds: tuple[float, float] = (-math.inf, math.inf),
    into: str = "",
) -> Any:
    """Declare a parameter of a defect; the default is that of the thesis's machine, or a plausible
    size.

    into: field that `install` sets, of the machine record or `RECORD.FIELD` of a `Site`.
    """
    data = {"unit": unit, "note": note, "bounds": bounds, "into": into}
    return field(default=default, metadata=data)


@dataclass(frozen=True)
class Defect:
    """Base class of the defects: parameters with units, source, channels that show the defect."""

    source: ClassVar[str] = ""
    touches: ClassVar[frozenset[str]] = frozenset()
    """channels that must show it"""
    spares: ClassVar[frozenset[str]] = frozenset()
    """channels that must not show it"""

    def __init_subclass__(cls) -> None:
        """Register the class under its YAML name: RoadPlay is road_play."""
        name = re.sub("(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        if name in _DEFECTS:
            raise ValueError(f"defect '{name}' exists twice")
        _DEFECTS[name] = cls

    def install(self, site: Site) -> None:
        """Apply the defect: set each parameter in the field that its `into` names."""
        for f in fields(self):
            if into := f.metadata["into"]:
                record, _, name = into.rpartition(".")
                getattr(site, record or "machine")[name] = getattr(self, f.name)


@cache
def defects() -> Mapping[str, type[Defect]]:
    """Name -> class of all defects."""
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        importlib.import_module(f"{__package__}.{module.name}")
    return dict(sorted(_DEFECTS.items()))


def build_defects(data: Mapping[str, Any], where: str) -> dict[str, Defect]:
    """Defects from YAML: {name: {parameter: value}}; null switches a defect off."""
    if not isinstance(data, Mapping):
        raise ParameterError(f"{where}: expected names of defects, found {data!r}")
    known = defects()
    result: dict[str, Defect] = {}
    for name, values in data.items():
        if name not in known:
            raise ParameterError(f"{where}: unknown defect '{name}'{nearest_hint(name, known)}")
        if values is None:
            continue
        place = f"{where}: {name}"
        made = values if isinstance(values, Defect) else from_mapping(known[name], values, place)
        validate(made, place)
        result[name] = made
    return result
