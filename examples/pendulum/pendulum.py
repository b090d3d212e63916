# SPDX-License-Identifier: Apache-2.0
"""A pendulum that swings out: viscous friction, where it fails, and what the engine says.

    python examples/pendulum/pendulum.py SWING.mat [MORE.csv ...]

A file is a `.mat` with a Simulink signal `Theta1` (or arrays `time` and `theta`) or a CSV with the
columns `time` and `theta` [s, rad]. Where the data of the README come from is said there.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.io import loadmat
from scipy.optimize import least_squares

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.search import run_search
from flatplank_analysis.discovery.verdict import Diagnosis, diagnose

NODES, STEPS, MOST = 48, 6, 30
"""nodes of a half swing, steps of the integration between two, half swings at most"""
STICK = 0.004
"""[rad/s] speed below which dry friction grows with the speed"""
SMALL = 40.0
"""encoder steps that the amplitude of a half swing has at least"""


class Torque(Effect):
    """What the pendulum feels beside its weight; `slow` gives the acceleration [rad/s2]."""

    coordinate = "speed"


@dataclass(frozen=True)
class Coulomb(Torque):
    """Dry friction of the bearing: of one size, against the motion."""

    identifier = "coulomb"
    title = "dry friction in the bearing"
    what = "The bearing resists alike at every speed: the swings get less by equal steps."
    check = "Let it swing out: it stops at an angle of its own and not in the lowest place."
    removes = "Bearings without seals, or air bearings."
    mu: float = param(0.0, unit="rad/s2", bounds=(0.0, 20.0), screen=0.02, matters=0.01)

    @staticmethod
    def slow(values, angle, speed):
        return values[0] * np.tanh(speed / STICK)


@dataclass(frozen=True)
class AirDrag(Torque):
    """A decoy: the air resists with the square of the speed."""

    identifier = "air_drag"
    title = "air resistance"
    what = "The air resists with the square of the speed: large swings lose most."
    check = "Add a sheet of paper."
    k: float = param(0.0, unit="1/rad", bounds=(0.0, 5.0), screen=0.02, matters=0.01)

    @staticmethod
    def slow(values, angle, speed):
        return values[0] * speed * np.abs(speed)


@dataclass(frozen=True)
class Spring(Torque):
    """A decoy: a cable that resists to large angles."""

    identifier = "cable"
    title = "a cable that pulls back"
    what = "A cable pulls back with the third power of the angle."
    check = "Take the cable off."
    k: float = param(0.0, unit="1/s2", bounds=(-500.0, 500.0), screen=1.0, matters=1.0)

    @staticmethod
    def slow(values, angle, speed):
        return values[0] * angle**3


EFFECTS = (Coulomb, AirDrag, Spring)


class Pendulum:
    """Angle [rad] from every turning point to the next: weight and viscous friction."""

    parameters = (
        Parameter("stiffness", "1/s2", 50.0, 1.0, 1e3, 0.5),
        Parameter("viscous", "1/s", 0.1, 0.0, 10.0, 0.01),
        Parameter("zero", "rad", 0.0, -0.2, 0.2, 1e-3),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def stiff(self, base):
        """The pendulum hangs a little differently every time."""
        return ({"zero": 1.0},)

    def predict(self, lanes):
        return np.stack([self._one(lane)[None] for lane in lanes])

    def _one(self, lane):
        stiffness, viscous, zero = lane.base
        angle, dt = self.runs.facts["start"].copy(), self.runs.facts["node"] / STEPS
        speed, out = np.zeros_like(angle), np.empty(self.runs.time.shape)

        def gain(x, v):
            slow = sum(e.slow(values, x, v) for e, values in lane.effects)
            return -stiffness * np.sin(x - zero) - viscous * v - slow

        for n in range(NODES):
            out[:, n] = angle
            for _ in range(STEPS):
                middle = speed + 0.5 * dt * gain(angle, speed)
                speed = speed + dt * gain(angle + 0.5 * dt * speed, middle)
                angle = angle + dt * middle
        return out


def load(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and angle [rad] from the lowest place, as recorded."""
    if path.suffix == ".mat":
        data = loadmat(path, squeeze_me=True, struct_as_record=False)
        signal = data.get("Theta1")
        pair = (signal.time, signal.signals.values) if signal is not None else (
            data["time"], data["theta"])  # fmt: skip
    else:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
        pair = tuple([float(r[k]) for r in rows] for k in ("time", "theta"))
    time, angle = (np.asarray(v, dtype=float) for v in pair)
    lowest = np.round(0.5 * (angle.max() + angle.min()) / np.pi) * np.pi
    return time - time[0], angle - lowest


def turning_points(time: np.ndarray, angle: np.ndarray, step: float) -> np.ndarray:
    """Time [s] and angle [rad] of every turn of a swing that the encoder resolves (turns, 2)."""
    side, turns, last = 0.0, [], 0
    for i, x in enumerate(angle):
        if abs(x) > SMALL * step and np.sign(x) != side:
            turns.append((last, i))
            side, last = np.sign(x), i
    spans = [*turns[1:], (last, len(time))]
    peaks = [a + int(np.argmax(np.abs(angle[a:b]))) for a, b in spans]
    near = 0.15 * float(np.median(np.diff(time[peaks]))) if len(peaks) > 2 else 0.0
    kept = [p for p in peaks if time[0] + 2.0 * near < time[p] < time[-1] - 2.0 * near]
    return np.array([_vertex(time, angle, time[p], near) for p in kept]).reshape(-1, 2)


def _vertex(time: np.ndarray, angle: np.ndarray, at: float, near: float) -> tuple[float, float]:
    """Of two half parabolas: with dry friction the curvature is another one after the turn."""
    rows = np.flatnonzero(np.abs(time - at) < near)
    t, x = time[rows] - at, angle[rows]

    def off(z):
        u = t - near * z[0]
        return (z[1] + np.where(u < 0.0, z[2], z[3]) * (u / near) ** 2) * scale - x

    scale = float(np.abs(x).max())
    bend = np.polyfit(t / near, x / scale, 2)
    z = least_squares(off, [0.0, bend[2], bend[0], bend[0]]).x
    return at + near * z[0], z[1] * scale


def _step(angle: np.ndarray) -> float:
    """Encoder step [rad]: the smallest change; of a smooth signal its finest noise."""
    change = np.abs(np.diff(angle))
    return float(np.median(np.sort(change[change > 1e-9])[: max(len(change) // 200, 1)]))


def read(paths: list[Path]) -> RunSet:
    """Half swings of the files; the floor is by the resolution of the encoder."""
    names, rows, starts, steps = [], [], [], []
    for path in paths:
        time, angle = load(path)
        steps.append(_step(angle))
        turns = turning_points(time, angle, steps[-1])
        halves = list(zip(turns, turns[1:, 0], strict=False))
        for i, ((begin, top), end) in enumerate(halves[:: max(1, -(-len(halves) // MOST))]):
            nodes = begin + (end - begin) * np.arange(NODES) / NODES
            names.append(f"{path.stem}, half swing {i + 1}")
            rows.append((nodes - begin, np.interp(nodes, time, angle)))
            starts.append(top)
    time, measured = (np.array([r[k] for r in rows]) for k in (0, 1))
    return RunSet(
        names=tuple(names),
        condition=np.arange(len(names)),
        condition_names=tuple(names),
        channels=("angle",),
        units=("rad",),
        measured=measured[None],
        time=time,
        order=np.arange(len(names), dtype=float),
        coordinates={
            "time": Coordinate(time.copy(), "s"),
            "speed": Coordinate(np.gradient(measured, axis=1) / time[:, 1:2], "rad/s"),
        },
        resolution=(max(steps),),
        facts={"start": np.array(starts), "node": time[:, 1]},
    )


def main(paths: list[str]) -> Diagnosis:
    """Search, and say what was found."""
    result = diagnose(run_search(Pendulum(read([Path(p) for p in paths])), list(EFFECTS)))
    print(text_of(result))
    return result


if __name__ == "__main__":
    main(sys.argv[1:] or sys.exit(__doc__))
