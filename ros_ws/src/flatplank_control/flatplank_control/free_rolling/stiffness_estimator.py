# SPDX-License-Identifier: Apache-2.0
"""Stiffness and relaxation length of the tire, estimated from the first centimetres of a run.

Least squares on the integrated transient tire, F = F_0 + C_x (r_e theta - x) - (1/sigma) int F dx,
with the travel x of the road and the angle theta of the wheel since the start. Linear in C_x,
C_x r_e, 1/sigma and F_0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

SIGMA = (0.05, 2.0)
"""relaxation lengths that are believed [m]"""
_N = 4


class Tire(NamedTuple):
    """An estimate; NaN where the run did not tell."""

    stiffness: float
    """C_x [N/m]"""
    relaxation: float
    """sigma [m]; the least certain of the three, and the one that the gains hardly need"""
    effective_radius: float
    """[m]"""


UNKNOWN = Tire(math.nan, math.nan, math.nan)


class StiffnessEstimator:
    """Sums of the normal equations, one sample per cycle; `solve` once at the end."""

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self._sums = [0.0] * 15
        self._count = 0
        self._integral = 0.0
        self._before: tuple[float, float] | None = None

    def add(self, x: float, angle: float, force: float) -> None:
        """Travel [m], wheel angle [rad] and force [N] since the start; about 2 us."""
        if self._before is not None:
            self._integral += 0.5 * (force + self._before[1]) * (x - self._before[0])
        self._before = (x, force)
        # metres times 1e3 and N m as they are: columns of one size
        s, r, i = 1e3 * (self._radius * angle - x), 1e3 * x, self._integral
        t = self._sums
        t[0] += s * s
        t[1] += s * r
        t[2] += s * i
        t[3] += s
        t[4] += r * r
        t[5] += r * i
        t[6] += r
        t[7] += i * i
        t[8] += i
        t[9] += s * force
        t[10] += r * force
        t[11] += i * force
        t[12] += force
        t[13] += force * force
        self._count += 1

    def solve(self) -> Tire:
        """The tire; UNKNOWN when the run was too quiet to tell."""
        t, n = self._sums, self._count
        if n <= 2 * _N:
            return UNKNOWN
        a = np.array([
            [t[0], t[1], t[2], t[3]], [t[1], t[4], t[5], t[6]],
            [t[2], t[5], t[7], t[8]], [t[3], t[6], t[8], float(n)],
        ])  # fmt: skip
        b = np.array(t[9:13])
        try:
            inverse = np.linalg.inv(a)
        except np.linalg.LinAlgError:
            return UNKNOWN
        p = inverse @ b
        variance = max(t[13] - float(p @ b), 0.0) / (n - _N)
        # s is made with a guess of r_e: C_x r_e / guess = p0 and C_x (r_e / guess - 1) = p1
        stiffness, error = 1e3 * (p[0] - p[1]), 1e3 * math.sqrt(max(variance * inverse[0, 0], 0.0))
        if not (stiffness > 0.0 and error < 0.2 * stiffness):
            return UNKNOWN
        sigma = -1.0 / p[2] if p[2] < 0.0 else math.inf
        known = SIGMA[0] < sigma < SIGMA[1]
        radius = self._radius * p[0] / (p[0] - p[1])
        return Tire(float(stiffness), float(sigma) if known else math.nan, float(radius))
