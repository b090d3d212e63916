# SPDX-License-Identifier: Apache-2.0
"""A spring that is moved by a given input: records without designed repeats."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.runs import Coordinate, RunSet

SAMPLES = 960
TIME = np.linspace(0.0, 96.0, SAMPLES)


@dataclass(frozen=True)
class Stiffening(Effect):
    """The spring gets stiffer as it is stretched."""

    identifier = "stiffening"
    title = "a spring that stiffens"
    what = "The coils touch each other, one after the other."
    check = "Hang weights on it."
    coordinate = "stretch"
    k: float = param(0.0, unit="N/m3", bounds=(-50.0, 50.0), screen=1.0, matters=0.2)

    @staticmethod
    def force(values, u, rate):
        return values[0] * u**3


@dataclass(frozen=True)
class Damper(Effect):
    """A decoy: a force in proportion to the speed."""

    identifier = "damper"
    title = "a damper"
    what = "Oil between the coils."
    check = "Move it at two speeds."
    coordinate = "time"
    d: float = param(0.0, unit="N s/m", bounds=(-20.0, 20.0), screen=0.5, matters=0.1)

    @staticmethod
    def force(values, u, rate):
        return values[0] * rate


class Spring:
    """Force of a linear spring with an offset."""

    parameters = (
        Parameter("c", "N/m", 8.0, 0.0, 50.0, 0.1),
        Parameter("zero", "N", 0.0, -5.0, 5.0, 0.1),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def scatter_directions(self, base):
        return ({"zero": 1.0},)

    def predict(self, sets):
        u = self.runs.inputs["stretch"]
        rate = np.gradient(u, TIME, axis=1)
        return np.stack(
            [
                (one.base[0] * u + one.base[1]
                 + sum(e.force(v, u, rate) for e, v in one.effects))[None]
                for one in sets
            ]
        )  # fmt: skip


def measured(*inputs: np.ndarray, seed: int = 1, k: float = 4.0, **known) -> Spring:
    """Records of a spring with c = 10 N/m that stiffens by k, one per input; noise of 0.05 N."""
    rng = np.random.default_rng(seed)
    u = np.array(inputs)
    slow = 0.002 * np.cumsum(rng.standard_normal(u.shape), axis=1)
    force = 10.0 * u + k * u**3 + 0.3 + 0.05 * rng.standard_normal(u.shape) + slow
    time = np.broadcast_to(TIME, u.shape).copy()
    runs = RunSet(
        names=tuple(f"record {i + 1}" for i in range(len(u))),
        condition=np.arange(len(u)),
        condition_names=tuple(f"record {i + 1}" for i in range(len(u))),
        channels=("force",),
        units=("N",),
        measured=force[None],
        time=time,
        order=np.arange(len(u), dtype=float),
        coordinates={"time": Coordinate(time.copy(), "s"), "stretch": Coordinate(u.copy(), "m")},
        inputs={"stretch": u},
    )
    return Spring(replace(runs, **known))


def sine(laps: int = 8, size: float = 1.0) -> np.ndarray:
    """A periodic input."""
    return size * np.sin(2.0 * np.pi * laps * np.arange(SAMPLES) / SAMPLES)


def stairs() -> np.ndarray:
    """Levels of the input, each held for a while, all visited twice in another order."""
    levels = np.array([0.0, 0.9, -0.6, 0.4, -1.0, 0.7, -0.3, 0.0, -1.0, 0.4, 0.9, -0.3, -0.6, 0.7])
    return np.interp(TIME, *_held(levels))


def _held(levels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    edges = np.linspace(0.0, TIME[-1], len(levels) + 1)
    at = np.ravel([(a, b - 0.8) for a, b in zip(edges, edges[1:], strict=False)])
    return at, np.repeat(levels, 2)


def there_and_back(top: float = 1.0) -> np.ndarray:
    """Slowly up and down once; it never comes to the same place in the same way."""
    half = SAMPLES // 2
    up = -0.2 + (top + 0.2) * np.linspace(0.0, 1.0, half) ** 1.3
    return np.concatenate([up, np.linspace(top, -0.1, SAMPLES - half)])


def ramps(count: int = 8) -> list[np.ndarray]:
    """Records that go one way only, each to another end."""
    return [np.linspace(-0.8, 0.3 + 0.1 * i, SAMPLES) for i in range(count)]
