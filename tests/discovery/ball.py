# SPDX-License-Identifier: Apache-2.0
"""A ball that falls: something for the engine that is no tire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.runs import Coordinate, RunSet

TIME = np.linspace(0.0, 2.0, 160)
HEIGHTS = (5.0, 10.0, 20.0)
THROWS = (0.0, 2.0, 4.0, 6.0)


@dataclass(frozen=True)
class Drag(Effect):
    """Air slows the ball down with the square of its speed."""

    identifier = "drag"
    kind = "machine"
    coordinate = "time"
    k: float = param(0.0, unit="1/m", bounds=(0.0, 0.5), screen=0.01, matters=0.002)


@dataclass(frozen=True)
class Wind(Effect):
    """A wind pushes upwards, growing with time."""

    identifier = "wind"
    kind = "machine"
    coordinate = "time"
    a: float = param(0.0, unit="m/s3", bounds=(-2.0, 2.0), screen=0.05, matters=0.02)


@dataclass(frozen=True)
class Shake(Effect):
    """The camera shakes."""

    identifier = "shake"
    kind = "sensor"
    coordinate = "time"
    a: float = param(0.0, unit="m", bounds=(-0.5, 0.5), screen=0.01, matters=0.005)


class Ball:
    """Height of a thrown ball; fitted: gravity and a timing offset of the camera."""

    parameters = (
        Parameter("g", "m/s2", 9.0, 5.0, 15.0, 0.1),
        Parameter("late", "s", 0.0, -0.1, 0.1, 0.01),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def scatter_directions(self, base):
        return ({"late": 1.0},)

    def predict(self, sets):
        return np.stack([self._one(one) for one in sets])

    def _one(self, one):
        g, late = one.base
        size = dict.fromkeys((Drag, Wind, Shake), 0.0)
        for effect, values in one.effects:
            size[effect] += values[0]
        k, a = size[Drag], size[Wind]
        z, v = self.runs.facts["height"].copy(), self.runs.facts["throw"].copy()
        v = v - (g * late)
        out = np.empty((len(z), len(TIME)))
        dt = TIME[1] - TIME[0]
        for n, t in enumerate(TIME):
            out[:, n] = z
            acceleration = -g - k * v * np.abs(v) + a * t
            z = z + v * dt + 0.5 * acceleration * dt**2
            v = v + acceleration * dt
        return out[None] + size[Shake] * np.sin(20.0 * TIME)


def throw(seed: int, k: float, repeats: int = 3, a: float = 0.0) -> Ball:
    """Throws measured by a camera with white noise of 2 cm and a slow drift."""
    rng = np.random.default_rng(seed)
    plan = [(h, v) for h in HEIGHTS for v in THROWS for _ in range(repeats)]
    kinds = sorted(set(plan))
    shape = (len(plan), len(TIME))
    runs = RunSet(
        names=tuple(f"throw {i}" for i in range(len(plan))),
        condition=np.array([kinds.index(p) for p in plan]),
        condition_names=tuple(f"{h} m, {v} m/s" for h, v in kinds),
        channels=("z",),
        measured=np.zeros((1, *shape)),
        time=np.broadcast_to(TIME, shape).copy(),
        order=np.arange(len(plan), dtype=float),
        coordinates={"time": Coordinate(np.broadcast_to(TIME, shape).copy(), "s", local=True)},
        facts={"height": np.array([h for h, _ in plan]), "throw": np.array([v for _, v in plan])},
    )
    ball = Ball(runs)
    hidden = ((Drag, np.array([k])), (Wind, np.array([a])))
    truth = ball.predict([ParameterSet(np.array([9.81, 0.01]), hidden)])[0]
    slow = np.cumsum(rng.standard_normal(shape), axis=1) * 0.001
    runs.measured[:] = truth + 0.02 * rng.standard_normal(shape) + slow
    return ball
