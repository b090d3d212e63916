# SPDX-License-Identifier: Apache-2.0
"""Balls dropped from a bridge: free fall, where it fails, and what the engine says is missing.

    python examples/falling_balls/falling_balls.py [DROPS.csv]

Ten balls, each dropped twice and filmed with 15 pictures a second (drops.csv; Brian de Silva and
others, Discovery of Physics from Data, 2020, MIT); or other drops with the same columns.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import flatplank_analysis as fp

FILE = Path(__file__).parent / "drops.csv"
AIR, USED = 1.2, 35 / 15.0
"""density [kg/m3]; time after the release that is used [s]"""


class Fall(fp.Motion):
    """Height below the release [m]: gravity, and how late the film saw the release."""

    g = fp.param(9.81, unit="m/s2", bounds=(9.3, 10.3), screen=0.1, prior=0.05)
    late = fp.param(0.0, unit="s", bounds=(-0.2, 0.2), screen=0.01)
    scatters = ("late",)

    def force(self, p, s):
        return p.g

    def begin(self, p, s):
        return 0.5 * p.g * p.late * np.abs(p.late), -p.g * p.late


class DragQuadratic(fp.Missing):
    """Air resistance by pressure. By area and speed squared; more so with holes in the ball."""

    check = "Drop balls of one size and two masses."
    cd = fp.param(0.0, unit="-", bounds=(0.0, 3.0), screen=0.1, matters=0.05)
    cd_holes = fp.param(0.0, unit="-", bounds=(0.0, 3.0), screen=0.1, matters=0.05)

    @staticmethod
    def damping(p, s):
        cd = np.where(s.holes, p.cd_holes, p.cd)
        return cd * 0.125 * np.pi * AIR * s.diameter**2 / s.mass * np.abs(s.v)


class DragLinear(fp.Missing):
    """Air resistance by viscosity. Proportional to diameter and speed (Stokes)."""

    check = "Drop a ball in a liquid."
    k = fp.param(0.0, unit="kg/(m s)", bounds=(0.0, 1.0), screen=0.01, matters=0.005)
    damping = staticmethod(lambda p, s: p.k * s.diameter / s.mass)


class Updraft(fp.Missing):
    """A push upward in proportion to the speed. A decoy: all balls are slowed alike."""

    check = "Drop a ball on a day without wind."
    a = fp.param(0.0, unit="1/s", bounds=(-2.0, 2.0), screen=0.05, matters=0.02)
    force = staticmethod(lambda p, s: -p.a * s.v)


def read(ball: str, drop: int, table) -> fp.Record:
    """A drop from its release on; release and start height from the first 0.75 s."""
    time, height = fp.column(table, "time"), fp.column(table, "height")
    early = time < 0.75

    def off(z):
        return z[1] - 4.905 * np.maximum(time[early] - z[0], 0.0) ** 2 - height[early]

    late, top = least_squares(off, [0.1, height[0]]).x
    facts = {k: float(table[k].iloc[0]) for k in ("mass", "diameter")}
    return fp.Record(
        f"{ball}, drop {drop}", time, top - height, condition=ball, span=(late, late + USED),
        facts=facts | {"holes": "Whiffle" in ball}, begin=(0.0, 0.0),
    )  # fmt: skip


def main(path: Path | str = FILE) -> fp.Diagnosed:
    """Search, and say what was found."""
    drops = fp.read_table(path).groupby(["ball", "drop"], sort=False)
    runs = fp.table_of([read(*of, rows) for of, rows in drops], "fallen", "m", nodes=36)
    result = fp.explain(Fall(runs), [DragQuadratic, DragLinear, Updraft])
    print(result)
    return result


if __name__ == "__main__":
    fp.script(main, *sys.argv[1:2])
