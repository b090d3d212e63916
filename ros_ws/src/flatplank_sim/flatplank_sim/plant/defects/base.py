# SPDX-License-Identifier: Apache-2.0
"""What a defect of the machine is: sizes with units, the channels that it touches, and where it is
built in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np

from flatplank_sim.plant.layout import MAP_START, MAP_STEP
from flatplank_sim.plant.yamlconfig import PlantConfigError

FORCES = frozenset({"fx", "fy", "fz"})
CHANNELS = [
    "fx",
    "fy",
    "fz",
    "mz",
    "lvdt_volts",
    "plank_counts",
    "wheel_counts",
    "steer_counts",
    "motor_position",
    "road_speed",
    "load",
    "fx_true",
    "c1",
    "c2",
    "c3",
    "c4",
    "c5",
    "c6",
]


class Site(NamedTuple):
    """The places of the bench where a defect can be built in; records of layout.py."""

    machine: np.ndarray
    tire: np.ndarray
    wheel_servo: np.ndarray
    road_map: np.ndarray
    """over plank position: friction factor, height of the plank [m], height of a cleat [m]"""
    mix: np.ndarray
    """measured from true (Fx, Fy, Fz, Mx, Mz) at the wheel centre"""
    drift: np.ndarray
    """C1..C6: offset [V], drift [V/s]; last row LVDT: offset [V], gain error"""

    def positions(self) -> np.ndarray:
        """Road position of the map's rows, zero at the motion trigger [m]."""
        x = np.arange(len(self.road_map)) * MAP_STEP - MAP_START
        return x - float(self.machine["trigger_at"][0])

    def use_map(self) -> None:
        """The road is no longer the same everywhere."""
        self.machine["mapped"] = 1


def size(
    default: Any, unit: str, note: str, bounds: tuple[float, float] = (-math.inf, math.inf)
) -> Any:
    """One parameter of a defect; its default is what the thesis's machine had, or a plausible
    size.
    """
    return field(default=default, metadata={"unit": unit, "note": note, "bounds": bounds})


@dataclass(frozen=True)
class Defect:
    """Base: nothing is wrong."""

    source: ClassVar[str] = ""
    touches: ClassVar[frozenset[str]] = frozenset()
    """channels that must show it"""
    spares: ClassVar[frozenset[str]] = frozenset()
    """channels that must not show it"""

    def install(self, site: Site) -> None:
        """Build it in."""

    def check(self, where: str) -> None:
        """Values inside their bounds."""
        for f in fields(self):
            low, high = f.metadata.get("bounds", (-math.inf, math.inf))
            value = getattr(self, f.name)
            for v in value if isinstance(value, tuple) else (value,):
                if isinstance(v, float | int) and not low <= v <= high:
                    unit = f.metadata["unit"]
                    raise PlantConfigError(
                        f"{where}: {f.name} = {v} {unit} is outside {low} .. {high}"
                    )
