# SPDX-License-Identifier: Apache-2.0
"""What can be hidden: a defect of the simulated machine, its size, and the effect that names it.

One line each. The names of effects are those that a diagnosis uses; nothing else of the analysis
is known here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Defects = Mapping[str, Mapping[str, Any]]

RUNS = 27
"""of the usual plan: what a size that grows from run to run is told over"""


@dataclass(frozen=True)
class Hidden:
    """One entry: `defects(size)` switches it on; `names` are the effect and what is like it."""

    names: tuple[str, ...]
    """empty: no effect of the library, the answer is `none of these` or `partly`"""
    unit: str
    low: float
    high: float
    defects: Callable[[float], Defects]
    runs: int = 0
    """of a size that grows from run to run: the runs over which it is told"""

    def draw(self, random: np.random.Generator) -> float:
        """A size, evenly over its logarithm."""
        return float(np.exp(random.uniform(np.log(self.low), np.log(self.high))))


MENU: dict[str, Hidden] = {
    "road_play": Hidden(
        ("road_play", "drive_backlash", "rack_backlash"), "m", 4e-4, 1.2e-3,
        lambda s: {"road_play": {"gap": s}},
    ),
    "rack_backlash": Hidden(
        ("rack_backlash", "drive_backlash", "road_play"), "m", 6e-4, 1.2e-3,
        lambda s: {"rack_backlash": {"gap": s}},
    ),
    "parasitic_force": Hidden(
        ("parasitic_force", "nonuniformity_1"), "N", 40.0, 200.0,
        lambda s: {"parasitic_shaft": {"fx": s, "fz": 0.8 * s}},
    ),
    "drive_brake_asymmetry": Hidden(
        ("drive_brake_asymmetry",), "1", 0.08, 0.15,
        lambda s: {"drive_brake_asymmetry": {"friction": s}},
    ),
    "mesh_ripple": Hidden(
        ("mesh_ripple",), "m", 2e-5, 8e-5,
        lambda s: {"mesh_ripple": {"tooth": 0.0, "turn": s}},
    ),
    "worn_patch": Hidden(
        ("worn_patch",), "1", 0.08, 0.20,
        lambda s: {"worn_patches": {"positions": [2.35], "factor": 1.0 - s, "length": 0.12}},
    ),
    "wear": Hidden(
        ("wear",), "1", 0.1, 0.25, lambda s: {"sandpaper_wear": {"per_run": s / (RUNS - 1)}}, RUNS,
    ),
    "nothing": Hidden((), "1", 1.0, 1.0, lambda _s: {}),
}  # fmt: skip
