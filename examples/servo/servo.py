# SPDX-License-Identifier: Apache-2.0
"""A servo that moves a pendulum: friction of one size, where it fails, and what the engine says.

    python examples/servo/servo.py FOLDER

FOLDER holds logs as `Rhoban/bam` writes them: one JSON per trajectory with `mass`, `arm_mass`
[kg], `length` [m], `kp`, `vin` [V] and `entries` of `timestamp` [s], `position`, `goal_position`
[rad] and `torque_enable`. Where data come from is said in the README.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.search import run_search
from flatplank_analysis.discovery.verdict import Diagnosis, diagnose

G, STEP, EVERY, MOST = 9.80665, 0.004, 10, 24
"""gravity; step of the integration [s], steps from one node to the next; logs at most"""


class Friction(Effect):
    """What the gear box resists with; `torque` gives the bound [N m] at a speed and a load."""

    coordinate = "load"


@dataclass(frozen=True)
class LoadFriction(Friction):
    """The teeth are pressed together by what they carry."""

    identifier = "load_friction"
    title = "friction in proportion to the load of the gear box"
    what = "The torque that the gear box carries presses its teeth together."
    check = "Hold two masses still and see how far the torque may go down before they move."
    removes = "A gear box of higher efficiency, or a direct drive."
    k: float = param(0.0, unit="1", bounds=(0.0, 0.9), screen=0.02, matters=0.01)

    @staticmethod
    def torque(values, speed, load):
        return values[0] * np.abs(load)


@dataclass(frozen=True)
class Stribeck(Friction):
    """A decoy: friction is larger as it begins to move."""

    identifier = "stribeck"
    title = "more friction at low speed"
    what = "Grease is pressed out at rest and comes back with the speed."
    check = "Move it very slowly: it sticks and slips."
    removes = "Another grease."
    k: float = param(0.0, unit="N m", bounds=(0.0, 5.0), screen=0.01, matters=0.005)
    speed: float = param(0.3, unit="rad/s", bounds=(0.02, 3.0))

    @staticmethod
    def torque(values, speed, load):
        return values[0] * np.exp(-((speed / max(values[1], 1e-3)) ** 2))


@dataclass(frozen=True)
class SpeedSquared(Friction):
    """A decoy: friction with the square of the speed."""

    identifier = "speed_squared"
    title = "friction with the square of the speed"
    what = "The grease is stirred."
    check = "Run it fast without a mass."
    k: float = param(0.0, unit="N m s2", bounds=(0.0, 1.0), screen=0.002, matters=0.001)

    @staticmethod
    def torque(values, speed, load):
        return values[0] * speed**2


EFFECTS = (LoadFriction, Stribeck, SpeedSquared)


class Servo:
    """Angle [rad]: a motor behind a proportional controller, a gear box with friction, a mass."""

    parameters = (
        Parameter("stall", "N m/V", 0.3, 0.005, 5.0, 0.01),
        Parameter("gain", "1/rad", 0.03, 1e-5, 10.0, 0.001),
        Parameter("brake", "N m s", 0.5, 0.0, 20.0, 0.02),
        Parameter("viscous", "N m s", 0.03, 0.0, 2.0, 0.005),
        Parameter("coulomb", "N m", 0.05, 0.0, 2.0, 0.005),
        Parameter("armature", "kg m2", 0.01, 0.0, 0.5, 0.001),
    )
    """torque per volt at rest; duty per count of kp and rad; loss of torque by the motor's own
    voltage; friction of the gear box; inertia of the rotor behind it"""

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    @property
    def starts(self) -> tuple[dict[str, float], ...]:
        """Servos differ by orders: other gains of their firmware, other sizes."""
        return tuple({"gain": g, "stall": s, "brake": b, "coulomb": 0.1 * s}
                     for g in (0.002, 0.02, 0.2) for s, b in ((0.1, 0.1), (0.8, 1.5)))  # fmt: skip

    def stiff(self, base):
        """The battery is not always as full."""
        return ({"stall": 0.1 * base[0]},)

    def predict(self, lanes):
        """All lanes at once: an array (lanes, runs) is integrated with dry friction."""
        facts, goal = self.runs.facts, self.runs.inputs["goal"]
        fine, on = self.runs.facts["fine"], self.runs.facts["on"]
        stall, gain, brake, viscous, coulomb, armature = np.array([lane.base for lane in lanes]).T[
            :, :, None
        ]
        inertia = facts["inertia"] + armature
        angle = np.repeat(facts["start"][None], len(lanes), axis=0)
        speed = np.zeros_like(angle)
        out = np.empty((len(lanes), 1, *goal.shape))
        for n in range(fine.shape[1]):
            if n % EVERY == 0:
                out[:, 0, :, n // EVERY] = angle
            duty = np.clip(gain * facts["kp"] * (fine[:, n] - angle), -1.0, 1.0)
            motor = (stall * facts["vin"] * duty - brake * speed) * on[:, n]
            weight = -facts["weight"] * np.sin(angle)
            bound = coulomb + viscous * np.abs(speed) + self._more(lanes, speed, motor - weight)
            free = speed + STEP * (motor + weight) / inertia
            most = STEP * bound / inertia
            speed = free - np.clip(free, -most, most)
            angle = angle + STEP * speed
        return out

    @staticmethod
    def _more(lanes, speed, load):
        out = np.zeros_like(speed)
        for i, lane in enumerate(lanes):
            for e, values in lane.effects:
                out[i] += e.torque(values, speed[i], load[i])
        return out


def read(folder: Path) -> RunSet:
    """The logs of a folder on common nodes; the floor is by the resolution of the encoder."""
    logs = [json.loads(p.read_text(encoding="utf-8")) for p in sorted(folder.glob("*.json"))]
    logs = logs[:: max(1, -(-len(logs) // MOST))]
    end = min(log["entries"][-1]["timestamp"] - log["entries"][0]["timestamp"] for log in logs)
    count = EVERY * (int(end / STEP) // EVERY)
    series = [_series(log, STEP * np.arange(count)) for log in logs]
    fine, on, measured = (np.array([s[k] for s in series]) for k in range(3))
    thin = slice(None, None, EVERY)
    time = np.broadcast_to(STEP * np.arange(count)[thin], measured[:, thin].shape).copy()
    mass, arm, length, kp, vin = (
        np.array([float(_of(log, k)) for log in logs])
        for k in ("mass", "arm_mass", "length", "kp", "vin")
    )
    names = tuple(f"{log.get('trajectory', 'log')} {i + 1}" for i, log in enumerate(logs))
    keys = [repr([_of(log, k) for k in KEYS]) for log in logs]
    kinds = list(dict.fromkeys(keys))
    weight = (mass + arm / 2.0) * G * length
    speed = np.gradient(measured[:, thin], STEP * EVERY, axis=1)
    return RunSet(
        names=names,
        condition=np.array([kinds.index(k) for k in keys]),
        condition_names=tuple(names[keys.index(k)] for k in kinds),
        channels=("angle",),
        units=("rad",),
        measured=measured[None, :, thin],
        time=time,
        order=np.arange(len(logs), dtype=float),
        coordinates={
            "time": Coordinate(time.copy(), "s"),
            "speed": Coordinate(speed, "rad/s"),
            "weight": Coordinate(weight[:, None] * np.sin(measured[:, thin]), "N m"),
        },
        inputs={"goal": fine[:, thin]},
        resolution=(max(s[3] for s in series),),
        facts={"start": measured[:, 0], "kp": kp, "vin": vin, "weight": weight, "fine": fine,
               "on": on, "inertia": (mass + arm / 3.0) * length**2},
    )  # fmt: skip


KEYS = ("mass", "arm_mass", "length", "kp", "vin", "trajectory")
OTHERWISE = {"arm_mass": ("arm-mass", 0.0), "trajectory": ("trajectory", "")}


def _of(log: Mapping, key: str):
    other, value = OTHERWISE.get(key, (key, None))
    return log.get(key, log.get(other, value))


def _series(log: Mapping, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Goal, whether torque is on, and position at the times `at` [s]; step of the encoder."""
    entries = log["entries"]
    time, goal, on, position = (
        np.array([float(e[k]) for e in entries])
        for k in ("timestamp", "goal_position", "torque_enable", "position")
    )
    levels = np.diff(np.unique(position))
    step = float(np.median(levels[levels > 1e-6]))
    time = time - time[0]
    held = on[np.searchsorted(time, at, side="right") - 1]
    return np.interp(at, time, goal), held, np.interp(at, time, position), step


def main(folder: str) -> Diagnosis:
    """Search, and say what was found."""
    result = diagnose(run_search(Servo(read(Path(folder))), list(EFFECTS)))
    print(text_of(result))
    return result


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else sys.exit(__doc__))
