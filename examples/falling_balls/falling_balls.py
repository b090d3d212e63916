# SPDX-License-Identifier: Apache-2.0
"""Balls dropped from a bridge: free fall, where it fails, and what the engine says is missing.

    python examples/falling_balls/falling_balls.py

Ten balls, each dropped twice and filmed with 15 pictures a second (drops.csv; Brian de Silva and
others, Discovery of Physics from Data, 2020, MIT). Nothing here is of tires: a model and three
effects, given to the same engine.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.search import run_search
from flatplank_analysis.discovery.verdict import Diagnosis, diagnose

FILE = Path(__file__).parent / "drops.csv"
AIR, NODES, RATE, STEPS = 1.2, 36, 15.0, 4
"""density [kg/m3]; pictures that are used, and per second; steps from one to the next"""


class Drag(Effect):
    """What slows a ball; `slow` gives the acceleration upwards [m/s2] at a speed downwards."""

    coordinate = "speed"


@dataclass(frozen=True)
class DragOfPressure(Drag):
    """Pressure in front of the ball: the square of the speed, the area over the mass."""

    identifier = "drag_quadratic"
    title = "air resistance by pressure"
    what = "The ball pushes the air aside: by area and speed squared; more so with holes in it."
    check = "Drop balls of one size and two masses."
    cd: float = param(0.0, unit="1", bounds=(0.0, 3.0), screen=0.1, matters=0.05)
    cd_holes: float = param(0.0, unit="1", bounds=(0.0, 3.0), screen=0.1, matters=0.05)

    @staticmethod
    def slow(values, speed, facts):
        cd = np.where(facts["holes"], values[1], values[0])
        return cd * 0.5 * AIR * facts["area"] / facts["mass"] * speed * np.abs(speed)


@dataclass(frozen=True)
class DragOfViscosity(Drag):
    """Viscous air: the speed, the diameter over the mass."""

    identifier = "drag_linear"
    title = "air resistance by viscosity"
    what = "The air sticks to the ball: proportional to diameter and speed (Stokes)."
    check = "Drop a ball in a liquid."
    k: float = param(0.0, unit="kg/(m s)", bounds=(0.0, 1.0), screen=0.01, matters=0.005)

    @staticmethod
    def slow(values, speed, facts):
        return values[0] * facts["diameter"] / facts["mass"] * speed


@dataclass(frozen=True)
class Updraft(Drag):
    """A decoy: something that slows all balls alike."""

    identifier = "updraft"
    title = "a push upward in proportion to the speed"
    what = "All balls are slowed alike, whatever their mass and diameter."
    check = "Drop a ball on a day without wind."
    a: float = param(0.0, unit="1/s", bounds=(-2.0, 2.0), screen=0.05, matters=0.02)

    @staticmethod
    def slow(values, speed, facts):
        return values[0] * speed


EFFECTS = (DragOfPressure, DragOfViscosity, Updraft)


class Fall:
    """Height below the release [m]: gravity, and how late the film saw the release."""

    parameters = (
        Parameter("g", "m/s2", 9.81, 9.3, 10.3, 0.1, prior=0.05),
        Parameter("late", "s", 0.0, -0.2, 0.2, 0.01),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def stiff(self, base):
        """The moment of release is seen a little differently in every drop."""
        return ({"late": 1.0},)

    def predict(self, lanes):
        return np.stack([self._one(lane)[None] for lane in lanes])

    def _one(self, lane):
        g, late = lane.base
        facts, dt = self.runs.facts, 1.0 / RATE / STEPS
        # free fall before the first node; what it was slowed by then is too small to see
        speed = np.full(self.runs.runs, -g * late)
        fallen = np.zeros(self.runs.runs) + 0.5 * g * late * np.abs(late)
        out = np.empty((self.runs.runs, NODES))
        for n in range(NODES):
            out[:, n] = fallen
            for _ in range(STEPS):
                middle = speed + 0.5 * dt * self._gain(lane, g, speed, facts)
                speed = speed + dt * self._gain(lane, g, middle, facts)
                fallen = fallen + dt * middle
        return out

    @staticmethod
    def _gain(lane, g, speed, facts):
        return g - sum(e.slow(values, speed, facts) for e, values in lane.effects)


def read() -> RunSet:
    """The drops from their release on, at 15 pictures a second."""
    drops: dict[tuple[str, int], list[dict[str, str]]] = defaultdict(list)
    for row in csv.DictReader(FILE.read_text(encoding="utf-8").splitlines()):
        drops[row["ball"], int(row["drop"])].append(row)
    balls = sorted({ball for ball, _ in drops})
    measured = np.array([_from_release(rows) for rows in drops.values()])
    time = np.broadcast_to(np.arange(NODES) / RATE, measured.shape)
    mass, diameter = (
        np.array([float(r[0][k]) for r in drops.values()]) for k in ("mass", "diameter")
    )
    return RunSet(
        names=tuple(f"{ball}, drop {n}" for ball, n in drops),
        condition=np.array([balls.index(ball) for ball, _ in drops]),
        condition_names=tuple(balls),
        channels=("fallen",),
        units=("m",),
        measured=measured[None],
        time=time.copy(),
        order=np.arange(len(drops), dtype=float),
        coordinates={
            "time": Coordinate(time.copy(), "s", local=True),
            "speed": Coordinate(np.gradient(measured, 1.0 / RATE, axis=1), "m/s"),
        },
        facts={
            "mass": mass,
            "diameter": diameter,
            "area": 0.25 * np.pi * diameter**2,
            "holes": np.array(["Whiffle" in ball for ball, _ in drops]),
        },
    )


def _from_release(rows: list[dict[str, str]]) -> np.ndarray:
    """How far it has fallen at the nodes; release and start height from the first 0.75 s."""
    time, height = (np.array([float(r[k]) for r in rows]) for k in ("time", "height"))
    early = time < 0.75

    def off(z):
        since = np.maximum(time[early] - z[0], 0.0)
        return z[1] - 0.5 * 9.81 * since**2 - height[early]

    late, top = least_squares(off, [0.1, height[0]]).x
    return top - CubicSpline(time, height)(late + np.arange(NODES) / RATE)


def main() -> Diagnosis:
    """Search, and say what was found."""
    result = diagnose(run_search(Fall(read()), list(EFFECTS)))
    print(text_of(result))
    return result


if __name__ == "__main__":
    main()
