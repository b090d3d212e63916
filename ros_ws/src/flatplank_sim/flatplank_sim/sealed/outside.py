# SPDX-License-Identifier: Apache-2.0
"""Forces that are in no library: what they add to Fx, and where it ought to be found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flatplank_sim.sealed.conditions import STEP, Columns, Run

Force = Callable[[Columns, Run], np.ndarray]
Made = tuple[Force, dict[str, Any]]


def bump(size: float, random: np.random.Generator) -> Made:
    """A pull between two places of the plank, only when driving or only when braking."""
    start, length = random.uniform(1.8, 3.0), random.uniform(0.4, 0.9)
    sign = float(random.choice([-1.0, 1.0]))

    def force(c: Columns, run: Run) -> np.ndarray:
        u = (c["plank_position"] - start) / length
        inside = (u > 0.0) & (u < 1.0) & (sign * run.setting.kappa > 0.0)
        return size * np.where(inside, np.sin(np.pi * u), 0.0)

    return force, {"coordinate": "plank position", "range": [start, start + length]}


def hum(size: float, random: np.random.Generator) -> Made:
    """A wave over the plank that is there with one sign of the slip only."""
    period, phase = random.uniform(0.12, 0.5), random.uniform(0.0, 6.28)
    sign = float(random.choice([-1.0, 1.0]))

    def force(c: Columns, run: Run) -> np.ndarray:
        x = c["plank_position"]
        on = (x > STEP) & (sign * run.setting.kappa > 0.0)
        return size * np.where(on, np.sin(2.0 * np.pi * x / period + phase), 0.0)

    return force, {"coordinate": "plank position", "range": [STEP, 4.15], "period": period}


def ringing(size: float, random: np.random.Generator) -> Made:
    """A wave that dies away after the step, the same whatever the slip."""
    period, fade = random.uniform(0.15, 0.4), random.uniform(0.5, 1.0)

    def force(c: Columns, run: Run) -> np.ndarray:
        d = c["plank_position"] - STEP
        wave = np.sin(2.0 * np.pi * d / period) * np.exp(-np.maximum(d, 0.0) / fade)
        return 2.0 * size * np.where(d > 0.0, wave, 0.0) * (run.setting.kappa != 0.0)

    where = {"coordinate": "distance since the step", "range": [0.0, 2.0 * fade]}
    return force, where | {"period": period}


def notch(size: float, random: np.random.Generator) -> Made:
    """The force falls for a while at one place, the more the smaller the slip."""
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
