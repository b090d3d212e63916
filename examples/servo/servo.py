# SPDX-License-Identifier: Apache-2.0
"""A servo that moves a pendulum: friction of one size, where it fails, and what the engine says.

    python examples/servo/servo.py FOLDER

FOLDER holds logs as `Rhoban/bam` writes them: one JSON per trajectory with `mass`, `arm_mass`
[kg], `length` [m], `kp`, `vin` [V] and `entries` of `timestamp` [s], `position`, `goal_position`
[rad] and `torque_enable`. Where data come from is said in the README.
"""

import sys
from pathlib import Path

import numpy as np

import flatplank_analysis as fp

G, MOST = 9.80665, 24
"""gravity [m/s2]; logs at most"""
INPUTS = {"goal": "goal_position", "on": "torque_enable"}


class Servo(fp.Motion):
    """Angle [rad]: a motor behind a proportional controller, a gear box with friction, a mass."""

    stall = fp.param(0.3, unit="N m/V", bounds=(0.005, 5.0), screen=0.01)
    gain = fp.param(0.03, unit="1/rad", bounds=(1e-5, 1.0), screen=0.001)
    brake = fp.param(0.5, unit="N m s", bounds=(0.0, 20.0), screen=0.02)
    viscous = fp.param(0.03, unit="N m s", bounds=(0.0, 2.0), screen=0.005)
    coulomb = fp.param(0.05, unit="N m", bounds=(0.0, 2.0), screen=0.005)
    armature = fp.param(0.01, unit="kg m2", bounds=(0.0, 0.5), screen=0.001)
    steps, scatters = 5, ("stall",)  # the battery is not always as full
    # servos differ by orders: other gains of their firmware, other sizes
    starts = tuple(dict(gain=g, stall=s, brake=b, coulomb=0.1 * s)
                   for g in (0.002, 0.02, 0.2) for s, b in ((0.1, 0.1), (0.8, 1.5)))  # fmt: skip

    def drive(self, p, s):
        duty = np.clip(p.gain * s.kp * (s.goal - s.x), -1.0, 1.0)
        return p.stall * s.vin * duty * s.on

    def force(self, p, s):
        return self.drive(p, s) - s.weight * np.sin(s.x)

    def damping(self, p, s):
        return p.brake * s.on

    def friction(self, p, s):
        return p.coulomb + p.viscous * np.abs(s.v)

    def inertia(self, p, s):
        return s.arm + p.armature

    def load(self, p, s):
        return self.drive(p, s) - p.brake * s.on * s.v + s.weight * np.sin(s.x)


class LoadFriction(fp.Missing):
    """Friction in proportion to the load of the gear box. What it carries presses its teeth."""

    coordinate = "weight"
    check = "Hold two masses still and see how far the torque may go down before they move."
    removes = "A gear box of higher efficiency, or a direct drive."
    k = fp.param(0.0, unit="1", bounds=(0.0, 0.9), screen=0.02, matters=0.01)
    friction = staticmethod(lambda p, s: p.k * np.abs(s.load))


class Stribeck(fp.Missing):
    """More friction at low speed. Grease is pressed out at rest and comes back with the speed."""

    check = "Move it very slowly: it sticks and slips."
    k = fp.param(0.0, unit="N m", bounds=(0.0, 5.0), screen=0.01, matters=0.005)
    speed = fp.param(0.3, unit="rad/s", bounds=(0.02, 3.0))
    friction = staticmethod(lambda p, s: p.k * np.exp(-((s.v / p.speed) ** 2)))


class SpeedSquared(fp.Missing):
    """Friction with the square of the speed. The grease is stirred."""

    check = "Run it fast without a mass."
    k = fp.param(0.0, unit="N m s2", bounds=(0.0, 1.0), screen=0.002, matters=0.001)
    friction = staticmethod(lambda p, s: p.k * s.v**2)


def read(path: Path) -> fp.Record:
    """A log; those of the same mass, length, gain, supply and trajectory repeat each other."""
    table = fp.read_table(path)
    log = {"arm_mass": table.attrs.get("arm-mass", 0.0), "trajectory": "log"} | table.attrs
    mass, arm, length, kp, vin = (log[k] for k in ("mass", "arm_mass", "length", "kp", "vin"))
    angle = fp.column(table, "position", where=str(path))
    weight = (mass + arm / 2) * G * length
    return fp.Record(
        f"{log['trajectory']} of {path.stem}", fp.column(table, "timestamp"), angle,
        inputs={k: fp.column(table, v) for k, v in INPUTS.items()},
        facts={"kp": kp, "vin": vin, "weight": weight, "arm": (mass + arm / 3) * length**2},
        condition=f"{log['trajectory']}, {mass} kg, {arm} kg, {length} m, kp {kp}, {vin} V",
        coordinates={"weight": (weight * np.sin(angle), "N m")},
    )  # fmt: skip


def main(folder: str) -> fp.Diagnosed:
    """Search in the logs of a folder, evenly chosen, and say what was found."""
    paths = sorted(Path(folder).glob("*.json"))
    records = [read(path) for path in paths[:: max(1, -(-len(paths) // MOST))]]
    result = fp.explain(Servo(fp.table_of(records, "angle", "rad", nodes=150)),
                        [LoadFriction, Stribeck, SpeedSquared])  # fmt: skip
    print(result)
    return result


if __name__ == "__main__":
    fp.script(main, sys.argv[1] if len(sys.argv) > 1 else sys.exit(__doc__))
