# SPDX-License-Identifier: Apache-2.0
"""Points of the shipped tire, for the tests of the Magic Formula fit."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.identify.mf.points import SteadyPoints, steady_points
from flatplank_analysis.identify.mf.problem import OutputProblem
from flatplank_analysis.identify.mf.stages import COEFFICIENTS
from flatplank_tire.magic_formula import steady_forces
from flatplank_tire.tir import TirFile, shipped_tir

TIR = shipped_tir()
C = TIR.coefficients
LOADS = np.array([1850.0, 3700.0, 5550.0])


def points(n: int = 6, **axes) -> SteadyPoints:
    facts = {"fz": np.full(n, 3700.0), "pressure": 2.5e5} | axes
    return steady_points({"fx": np.arange(float(n))}, **facts)


def problem(**more) -> OutputProblem:
    kappa = np.tile([-0.1, -0.02, 0.0, 0.02, 0.1], 3)
    fz = np.repeat(LOADS, 5)
    fx = steady_forces(C, fz, kappa, 0.0, 0.0, 2.5e5, 0.03)[0]
    p = steady_points({"fx": fx}, fz=fz, kappa=kappa, pressure=2.5e5)
    return OutputProblem(
        **{"output": "fx", "points": p, "free": ("PKX1", "PEX1"), "base": C, **more}
    )


def whole_tire() -> TirFile:
    """Every coefficient of the forces away from zero."""
    moved = {"LATERAL_STIFFNESS": 1e5, "QBZ1": 9.0, "QCZ1": 1.2, "QDZ1": 0.1, "QDZ6": 0.01,
             "QBZ9": 5.0, "QBZ10": 1.0, "SSZ1": 0.1, "RBX1": 9.0, "RBX2": 9.0, "RCX1": 1.0,
             "RBY1": 9.0, "RBY2": 9.0, "RCY1": 1.0, "RVY1": 0.1, "RVY4": 9.0, "RVY5": 1.9,
             "RVY6": 10.0, "Q_FZ2": 10.0, "BREFF": 6.0, "DREFF": 0.25, "FREFF": 0.02}  # fmt: skip
    return TIR.replaced({n: v.start or 0.1 for n, v in COEFFICIENTS.items()} | moved)
