# SPDX-License-Identifier: Apache-2.0
"""List of what can be hidden: a defect of the simulated machine, its size, and its effect names.

The names of effects are those of the diagnosis; this module uses nothing else of the analysis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_sim.sealed.conditions import STEP, Columns, Run

Defects = Mapping[str, Mapping[str, Any]]

RUNS = 27
"""runs of the usual plan, for a size that grows from run to run"""


@dataclass(frozen=True)
class Hidden:
    """One entry: `defects(size)` returns its defects; `names` are the effect and its relatives."""

    names: tuple[str, ...]
    """empty: no effect of the library; the right verdict is `none of these` or `partly`"""
    unit: str
    low: float
    high: float
    defects: Callable[[float], Defects]
    runs: int = 0
    """number of runs to which a size refers that grows from run to run"""

    def draw(self, random: np.random.Generator) -> float:
        """Draw a size, uniform in its logarithm."""
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

CLOSE: dict[str, Hidden] = {
    "shaft_force": Hidden(
        ("parasitic_force", "nonuniformity_1"), "N", 50.0, 70.0,
        lambda s: {"parasitic_shaft": {"fx": s, "fz": 0.0}},
    ),
}  # fmt: skip
"""what the runs of a short campaign cannot tell from a look-alike; chosen by name, never drawn"""

Force = Callable[[Columns, Run], np.ndarray]
Made = tuple[Force, dict[str, Any]]


def bump(size: float, random: np.random.Generator) -> Made:
    """A force between two plank positions, only when driving or only when braking."""
    start, length = random.uniform(1.8, 3.0), random.uniform(0.4, 0.9)
    sign = float(random.choice([-1.0, 1.0]))

    def force(c: Columns, run: Run) -> np.ndarray:
        u = (c["plank_position"] - start) / length
        inside = (u > 0.0) & (u < 1.0) & (sign * run.setting.kappa > 0.0)
        return size * np.where(inside, np.sin(np.pi * u), 0.0)

    return force, {"coordinate": "plank position", "range": [start, start + length]}


def hum(size: float, random: np.random.Generator) -> Made:
    """A periodic force over the plank position, for one sign of slip only."""
    period, phase = random.uniform(0.12, 0.5), random.uniform(0.0, 6.28)
    sign = float(random.choice([-1.0, 1.0]))

    def force(c: Columns, run: Run) -> np.ndarray:
        x = c["plank_position"]
        on = (x > STEP) & (sign * run.setting.kappa > 0.0)
        return size * np.where(on, np.sin(2.0 * np.pi * x / period + phase), 0.0)

    return force, {"coordinate": "plank position", "range": [STEP, 4.15], "period": period}


def ringing(size: float, random: np.random.Generator) -> Made:
    """A decaying oscillation after the step, independent of slip."""
    period, fade = random.uniform(0.15, 0.4), random.uniform(0.5, 1.0)

    def force(c: Columns, run: Run) -> np.ndarray:
        d = c["plank_position"] - STEP
        wave = np.sin(2.0 * np.pi * d / period) * np.exp(-np.maximum(d, 0.0) / fade)
        return 2.0 * size * np.where(d > 0.0, wave, 0.0) * (run.setting.kappa != 0.0)

    where = {"coordinate": "distance since the step", "range": [0.0, 2.0 * fade]}
    return force, where | {"period": period}


def notch(size: float, random: np.random.Generator) -> Made:
    """A local drop of the force at one plank position, larger at small slip."""
    start, length = random.uniform(2.0, 3.2), random.uniform(0.25, 0.5)

    def force(c: Columns, run: Run) -> np.ndarray:
        u = (c["plank_position"] - start) / length
        inside = (u > 0.0) & (u < 1.0)
        part = max(1.0 - abs(run.setting.kappa) / 0.03, 0.0)
        return -2.0 * size * part * np.where(inside, np.sin(np.pi * u) ** 2, 0.0)

    return force, {"coordinate": "plank position", "range": [start, start + length]}


OUTSIDE: dict[str, Callable[[float, np.random.Generator], Made]] = {
    "bump": bump, "hum": hum, "ringing": ringing, "notch": notch,
}  # fmt: skip
