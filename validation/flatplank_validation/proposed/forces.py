# SPDX-License-Identifier: Apache-2.0
"""Forces outside the library, and the right proposal for each.

Each maker returns a change of the columns of a run and the right answer: families of hooks,
coordinates, modulators and shapes. Only these terms come from the analysis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator as Random

from flatplank_sim.sealed.conditions import LOAD, STEP, Columns, Run, Setting
from flatplank_sim.sealed.menu import OUTSIDE, Force

TEMPERATURE, VOLTAGE = "temperature [degC]", "supply voltage [V]"


@dataclass(frozen=True)
class Truth:
    """The right answer; it has several terms where the runs cannot distinguish them."""

    families: tuple[str, ...]
    coordinates: tuple[str, ...]
    modulators: tuple[str, ...]
    shapes: tuple[str, ...]
    size: float | None = None
    """right size; None where the size depends on the form"""
    column: str = ""
    across: float = 1.0
    """change of the column to which the size refers; a proposal states the size over the measured
    range"""

    def seen(self, runs: Sequence[Columns]) -> Truth:
        """The answer with the size over the column's range in these runs."""
        if self.size is None or not self.column:
            return self
        values = [np.asarray(c[self.column], dtype=float) for c in runs]
        width = max(float(v.max()) for v in values) - min(float(v.min()) for v in values)
        return replace(self, size=self.size * width / self.across)

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "families": self.families, "coordinates": self.coordinates,
            "modulators": self.modulators, "shapes": self.shapes, "size": self.size,
        }  # fmt: skip


Change = Callable[[Columns, Run], Columns]
Maker = Callable[[float, Random], tuple[Change, Truth]]
PLANK = ("plank position", "distance since the step", "time")


@dataclass(frozen=True)
class Item:
    """One force: how it is made, the size of no consequence, the design that shows it."""

    make: Maker
    least: float
    design: str = "small"


def _outside(name: str, modulators: Sequence[str], shapes: Sequence[str], own: bool) -> Maker:
    def make(size: float, random: Random) -> tuple[Change, Truth]:
        force, _ = OUTSIDE[name](size, random)
        words = tuple(modulators)
        if own:  # the side was drawn with the force
            words = tuple(m for m in words if _on(force, m))
        truth = Truth(("signal",), PLANK, words, tuple(shapes), size if own else None)
        return (lambda c, run: c | {"fx": c["fx"] + force(c, run)}), truth

    return make


def _on(force: Force, side: str) -> bool:

    kappa = {"driving": 0.05, "braking": -0.05}[side]
    place = {"plank_position": np.linspace(0.0, 4.15, 400)}
    return bool(np.abs(force(place, Run(Setting(kappa), 1, 0))).max() > 0.0)


def _per_run(random: Random, low: float, high: float) -> Callable[[Run], float]:
    draws = random.uniform(low, high, 400)
    return lambda run: float(draws[run.index])


def warm(size: float, random: Random) -> tuple[Change, Truth]:
    """Fx depends on a temperature that varies from run to run and is in a column."""
    of = _per_run(random, 18.0, 32.0)

    def change(c: Columns, run: Run) -> Columns:
        t = of(run) + 0.4 * c["time"] / 130.0
        return c | {"fx": c["fx"] + size * (t - 25.0) / 14.0, TEMPERATURE: t}

    truth = Truth(("signal",), ("temperature",), ("",), ("ramp",), size, TEMPERATURE, 14.0)
    return change, truth


def supply(size: float, random: Random) -> tuple[Change, Truth]:
    """The amplifier gain depends on a supply voltage that is in a column; size in per mille."""
    of = _per_run(random, 9.4, 10.6)

    def change(c: Columns, run: Run) -> Columns:
        volts = of(run) + 0.02 * np.sin(c["time"] / 11.0)
        gain = 1.0 + 1e-3 * size * (volts - 10.0) / 1.2
        return c | {"fx": c["fx"] * gain, VOLTAGE: volts}

    truth = Truth(
        ("gain",), ("supply voltage",), ("",), ("ramp",), 1e-3 * size, VOLTAGE, 1.2
    )  # fmt: skip
    return change, truth


def overload(size: float, random: Random) -> tuple[Change, Truth]:
    """A stop is touched above a load: the force grows with the excess."""
    at = random.uniform(3000.0, 3900.0)

    def change(c: Columns, run: Run) -> Columns:
        return c | {"fx": c["fx"] + size * np.maximum(run.setting.fz - at, 0.0) / 2600.0}

    return change, Truth(("signal",), ("load",), ("",), ("threshold", "power", "step"), None)


def beat(size: float, random: Random) -> tuple[Change, Truth]:
    """Two waves over the plank with similar periods."""
    one, phase = random.uniform(0.25, 0.45), random.uniform(0.0, 6.28, 2)
    other = one * random.uniform(1.15, 1.35)

    def change(c: Columns, run: Run) -> Columns:
        x = 2.0 * np.pi * c["plank_position"]
        wave = np.sin(x / one + phase[0]) + np.sin(x / other + phase[1])
        return c | {"fx": c["fx"] + size * wave}

    return change, Truth(("signal", "motion"), PLANK, ("",), ("beat",), None)


def late(size: float, random: Random) -> tuple[Change, Truth]:
    """A delay of Fx that grows along the run; size in milliseconds at its end."""

    def change(c: Columns, run: Run) -> Columns:
        t = c["time"]
        delay = 1e-3 * size * t / t[-1]
        return c | {"fx": np.interp(t - delay, t, c["fx"])}

    shapes = ("ramp", "power", "threshold", "relaxation")
    return change, Truth(("delay",), PLANK, ("",), shapes, None)


def warming(size: float, random: Random) -> tuple[Change, Truth]:
    """Fx rises with the time since switching on, fast at first."""
    fade = random.uniform(10.0, 30.0)

    def change(c: Columns, run: Run) -> Columns:
        side = float(run.setting.kappa < 0.0)
        part = 1.0 - np.exp(-np.maximum(c["plank_position"] - STEP, 0.0) * 32.0 / fade)
        return c | {"fx": c["fx"] + size * side * part * run.setting.fz / LOAD}

    shapes = ("relaxation", "power", "step", "bump", "ramp", "threshold")
    return change, Truth(("signal",), PLANK, ("braking",), shapes, None)


FORCES: dict[str, Item] = {
    "bump": Item(_outside("bump", ("driving", "braking"), ("bump",), True), 5.0),
    "hum": Item(_outside("hum", ("driving", "braking"), ("wave",), True), 5.0),
    "ringing": Item(_outside("ringing", ("slipping", ""), ("ringing",), False), 5.0),
    "notch": Item(_outside("notch", ("little slip",), ("bump",), False), 5.0),
    "warm": Item(warm, 10.0),
    "supply": Item(supply, 10.0),
    "overload": Item(overload, 10.0, "loads"),
    "beat": Item(beat, 5.0),
    "late": Item(late, 40.0),
    "warming": Item(warming, 10.0),
}
