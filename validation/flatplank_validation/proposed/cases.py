# SPDX-License-Identifier: Apache-2.0
"""Makes a campaign of this kit from its name and a seed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from flatplank_data.table import MeasurementTable
from flatplank_sim.sealed.conditions import Columns, Run
from flatplank_validation.blind import cases as blind
from flatplank_validation.blind.detectable import detectable_force
from flatplank_validation.blind.menu import MENU
from flatplank_validation.blind.noise import NOISES, RELATIVE, shown
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.worlds import WORLDS, Scatter
from flatplank_validation.proposed.forces import FORCES, TEMPERATURE
from flatplank_validation.proposed.left_out import LEFT_OUT, PLAIN

KIT = ("plant", "second", "forms")
FACTOR = 3.0
"""size of a hidden force over its detectable size, or its size of no consequence if larger [-]"""
WORTH, QUIETER = 0.5, 6.0
"""size of a force over the scatter of the repeats; factor by which the filter reduces the power of
white noise [-]"""
NULL_NOISES = ("usual", "coloured", "quiet")
SCATTERS = (0.0, 0.01, 0.03)


@dataclass(frozen=True)
class Case:
    """Definition of one campaign."""

    group: str
    """force, left_out or null"""
    world: str
    name: str = "nothing"
    noise: str = "usual"
    scatter: float = 0.01
    design: str = "small"
    number: int = 0

    @property
    def key(self) -> str:
        """Key in the journal."""
        return (
            f"{self.group}/{self.world}/{self.name}/{self.noise}/s{self.scatter:g}/"
            f"{self.design}/{self.number}"
        )


def full(seed: int) -> list[Case]:
    """All cases of a seed, in mixed order, so that any first part is a representative sample."""
    draw = np.random.default_rng((seed, 77))
    lists = [list(_forces(draw)), list(_left_out(draw)), list(_nulls())]
    for cases in lists:
        draw.shuffle(cases)
    places = [(i + 0.5) / len(cases) for cases in lists for i in range(len(cases))]
    everything = [c for cases in lists for c in cases]
    return [everything[i] for i in np.argsort(places, kind="stable")]


def _forces(draw: np.random.Generator) -> Iterator[Case]:
    for name, item in FORCES.items():
        for world in KIT:
            for number in range(2):
                noise, scatter = _around(draw)
                yield Case("force", world, name, noise, scatter, item.design, number)


def _left_out(draw: np.random.Generator) -> Iterator[Case]:
    for name in LEFT_OUT:
        for world in KIT:
            if WORLDS[world](None).has(name):
                for number in range(2):
                    noise, scatter = _around(draw)
                    design = MENU[name].design
                    design = "small" if design == "plain" and name not in PLAIN else design
                    yield Case("left_out", world, name, noise, scatter, design, number)


def _nulls() -> Iterator[Case]:
    for world in KIT:
        for noise in NULL_NOISES:
            for i in range(12):
                yield Case("null", world, "nothing", noise, SCATTERS[i % 3], "small", i)


def _around(draw: np.random.Generator) -> tuple[str, float]:
    return str(draw.choice(NULL_NOISES)), float(draw.choice(SCATTERS[:2]))


def make(case: Case, seed: int) -> tuple[list[MeasurementTable], dict[str, Any]] | None:
    """Tables of a campaign and its answer; None when these runs cannot show it."""
    if case.group == "left_out":
        return _hidden(case, seed)
    random = np.random.default_rng((seed, crc32(case.key.encode())))
    world = WORLDS[case.world](random)
    runs = runs_of(case.design, random)
    scatter = Scatter.drawn(len(runs), case.scatter, random)
    columns = world.run(runs, {}, random, scatter)
    answer: dict[str, Any] = {"name": case.name}
    if case.group == "force":
        size = size_of(case, seed)
        if not math.isfinite(size):
            return None
        change, truth = FORCES[case.name].make(size, _drawn(case, seed))
        columns = [change(c, run) for c, run in zip(columns, runs, strict=True)]
        answer |= truth.seen(columns).to_dict() | {"hidden": size}
    elif case.number % 2:  # a column without influence
        draws = random.uniform(18.0, 32.0, len(runs))
        columns = [
            c | {TEMPERATURE: draws[r.index] + 0.0 * c["time"]}
            for c, r in zip(columns, runs, strict=True)
        ]
    noise = NOISES[case.noise]
    return [
        _table(c, r, world.radius, noise, random) for c, r in zip(columns, runs, strict=True)
    ], (answer)


def _hidden(case: Case, seed: int) -> tuple[list[MeasurementTable], dict[str, Any]] | None:
    made = [
        blind.Case("single", case.world, (case.name,), FACTOR, case.noise, case.scatter,
                   case.design, case.number, rung)
        for rung in ("x", "c")
    ]  # fmt: skip
    sizes = [blind.size_of(c, case.name) for c in made]
    finite = [(s, c) for s, c in zip(sizes, made, strict=True) if math.isfinite(s)]
    if not finite:
        return None
    size, best = max(finite, key=lambda pair: pair[0])
    found = blind.make(best, seed)
    if found is None:
        return None
    truth = LEFT_OUT[case.name].to_dict()
    return found[0], {"name": case.name, "hidden": size} | truth


def _drawn(case: Case, seed: int) -> np.random.Generator:
    return np.random.default_rng((seed, crc32(case.key.encode()), 1))


def size_of(case: Case, seed: int) -> float:
    """Size of a force: FACTOR times its detectable size, or a size of consequence if larger."""
    item = FORCES[case.name]
    change, _ = item.make(1.0, _drawn(case, seed))

    def force(c: Columns, run: Run) -> np.ndarray:
        return change(c, run)["fx"] - c["fx"]

    least = detectable_force(case.world, force, case.noise, case.scatter, case.design)
    return max(FACTOR * max(least, item.least), _counts(case, force))


def _counts(case: Case, force: Callable[[Columns, Run], np.ndarray]) -> float:
    """Size at which the force is WORTH times the scatter of the repeats; less is of no
    consequence."""
    draw = np.random.default_rng(5)
    runs = runs_of(case.design, draw)
    columns = WORLDS[case.world](None).run(runs, {}, draw, Scatter.none(len(runs)))
    made = [force(c, r) for c, r in zip(columns, runs, strict=True)]
    mean = np.mean([f.mean() for f in made])
    one = np.sqrt(np.mean([np.mean((f - mean) ** 2) for f in made]))
    level = np.mean([np.mean(c["fx"] ** 2) for c in columns])
    noise = NOISES[case.noise]
    repeats = noise.white**2 / QUIETER + noise.slow**2 + noise.quick**2 + level * case.scatter**2
    return float(WORTH * np.sqrt(repeats) / max(one, 1e-12))


def _table(c: Columns, run: Run, radius: float, noise, random) -> MeasurementTable:
    dt = float(c["time"][1] - c["time"][0])
    for name, share in RELATIVE.items():
        c[name] = shown(noise, c[name], dt, random, share)
    table = blind.measured_table(c, run, radius)
    more = {n: v for n, v in c.items() if "[" in n}
    return table.with_columns(**more) if more else table
