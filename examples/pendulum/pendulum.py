# SPDX-License-Identifier: Apache-2.0
"""A pendulum that swings out: viscous friction, where it fails, and what the engine says.

    python examples/pendulum/pendulum.py SWING.mat [MORE.csv ...]

A file has `time` [s] and `theta` or `angle` [rad]: a `.mat` (arrays, or a Simulink signal
`Theta1`) or a CSV. Where the data of the README come from is said there.
"""

import sys
from pathlib import Path

import numpy as np

import flatplank_analysis as fp


class Pendulum(fp.Motion):
    """Angle [rad]: weight and viscous friction, over the inertia."""

    stiffness = fp.param(50.0, unit="1/s2", bounds=(1.0, 1e3), screen=0.5)
    viscous = fp.param(0.1, unit="1/s", bounds=(0.0, 10.0), screen=0.01)
    zero = fp.param(0.0, unit="rad", bounds=(-0.2, 0.2), screen=1e-3)
    scatters = ("zero",)  # it hangs a little differently every time

    def force(self, p, s):
        return -p.stiffness * np.sin(s.x - p.zero)

    def damping(self, p, s):
        return p.viscous


class Coulomb(fp.Missing):
    """Dry friction in the bearing. It resists alike at every speed: equal steps of the swings."""

    check = "Let it swing out: it stops at an angle of its own and not in the lowest place."
    removes = "Bearings without seals, or air bearings."
    mu = fp.param(0.0, unit="rad/s2", bounds=(0.0, 20.0), screen=0.02, matters=0.01)
    friction = staticmethod(lambda p, s: p.mu)


class AirDrag(fp.Missing):
    """Air resistance. It grows with the square of the speed: large swings lose most."""

    check = "Add a sheet of paper."
    k = fp.param(0.0, unit="1/rad", bounds=(0.0, 5.0), screen=0.02, matters=0.01)
    damping = staticmethod(lambda p, s: p.k * np.abs(s.v))


class Cable(fp.Missing):
    """A cable that pulls back. It does so with the third power of the angle."""

    check = "Take the cable off."
    k = fp.param(0.0, unit="1/s2", bounds=(-500.0, 500.0), screen=1.0, matters=1.0)
    force = staticmethod(lambda p, s: -p.k * s.x**3)


def read(path: str) -> fp.Record:
    """Angle from the lowest place, as recorded."""
    table = fp.read_table(path)
    angle = fp.column(table, "theta", "Theta1", "angle", "position", where=path)
    lowest = np.round(0.5 * (angle.max() + angle.min()) / np.pi) * np.pi
    return fp.Record(Path(path).stem, fp.column(table, "time", "t", where=path), angle - lowest)


def main(paths: list[str]) -> fp.Diagnosed:
    """Search in the half swings of the files, and say what was found."""
    swings = [half for path in paths for half in fp.half_swings(read(path))]
    runs = fp.table_of(swings, "angle", "rad", nodes=48, alike=False)
    result = fp.explain(Pendulum(runs), [Coulomb, AirDrag, Cable])
    print(result)
    return result


if __name__ == "__main__":
    fp.script(main, sys.argv[1:] or sys.exit(__doc__))
