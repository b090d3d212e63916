# SPDX-License-Identifier: Apache-2.0
"""A sum of shapes over time as a model: so quick that the errors of the search can be counted."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.opening import Options
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.steps import Search
from flatplank_analysis.inference.search import run_search

TIME = np.linspace(0.0, 4.0, 120)
CONDITIONS, REPEATS = 8, 3
NOISE = 0.05
Form = Callable[[np.ndarray], np.ndarray]
"""condition of every run, -1 .. 1, shape (runs, 1) -> shape of the effect (runs, samples)"""


def wave(periods: float, phase: float = 0.0) -> np.ndarray:
    return np.sin(2.0 * np.pi * periods * TIME / TIME[-1] + phase)


def shape(name: str, form: Form, *, matters: float = 1e-4, bound: float = 5.0, **texts: Any):
    """An effect of one size: that of a form."""
    size = param(0.0, unit="1", bounds=(-bound, bound), screen=0.02, matters=matters)
    facts = {"identifier": name, "kind": "machine", "coordinate": "time", **texts}
    made = dataclasses.make_dataclass(
        name, [("a", float, size)], bases=(Effect,), frozen=True, namespace=facts
    )
    made.form = staticmethod(form)
    return made


LONG = shape("long", lambda c: (1.0 + 0.5 * c) * wave(1.5))
"""everywhere along the run, in every condition"""
OTHER = shape("other", lambda c: (1.0 - 0.5 * c) * wave(2.5, 1.0))


class Sum:
    """level + slope t + sum of shapes."""

    parameters = (
        Parameter("level", "1", 0.0, -5.0, 5.0, 0.1),
        Parameter("slope", "1", 0.0, -5.0, 5.0, 0.1),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs
        self.setting = runs.facts["setting"][:, None]

    def scatter_directions(self, base):
        return ()

    def predict(self, sets):
        out = np.empty((len(sets), *self.runs.measured.shape))
        for row, one in zip(out, sets, strict=True):
            row[0] = one.base[0] + one.base[1] * TIME
            for effect, values in one.effects:
                row[0] += self.part(effect, values)
        return out

    def part(self, effect, values) -> np.ndarray:
        """What an effect adds."""
        return values[0] * effect.form(self.setting)


@dataclasses.dataclass(frozen=True)
class Hum(Effect):
    """A wave whose pitch is fitted, too."""

    identifier, kind, coordinate = "hum", "machine", "time"
    a: float = param(0.0, unit="1", bounds=(-5.0, 5.0), screen=0.02, matters=0.05)
    pitch: float = param(0.9, unit="1/s", bounds=(0.5, 3.0))


class Hummed(Sum):
    """Level, slope and hums: from a far pitch no fit gets to the right one."""

    def part(self, effect, values):
        return values[0] * np.sin(2.0 * np.pi * values[1] * TIME)


def measured(seed: int, *hidden: tuple[np.ndarray | float, Form], noise: float = NOISE) -> Sum:
    """Runs with forms of some sizes, one for all runs or one per run (runs,)."""
    random = np.random.default_rng(seed)
    condition = np.repeat(np.arange(CONDITIONS), REPEATS)
    setting = np.linspace(-1.0, 1.0, CONDITIONS)[condition]
    runs = len(condition)
    time = np.broadcast_to(TIME, (runs, len(TIME))).copy()
    values = 1.0 + 0.1 * time + noise * random.standard_normal(time.shape)
    for size, form in hidden:
        values = values + np.reshape(size, (-1, 1)) * form(setting[:, None])
    return Sum(
        RunSet(
            names=tuple(f"run {i}" for i in range(runs)),
            condition=condition,
            condition_names=tuple(f"setting {s:g}" for s in np.unique(setting)),
            channels=("z",),
            measured=values[None],
            time=time,
            order=random.permutation(runs).astype(float),
            coordinates={"time": Coordinate(time, "s")},
            facts={"setting": setting},
        )
    )


def names(found: Sequence) -> set[str]:
    """Of what was accepted."""
    return {f.decision.term.effect.identifier for f in found}


def searched(model: Sum, *effects: type[Effect], **options: Any) -> Search:
    """The whole search."""
    return run_search(model, list(effects), Options(**options))
