# SPDX-License-Identifier: Apache-2.0
"""Settling distance of a free-rolling run (Appendix E)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from flatplank_data.machine import USABLE_ROAD

REFERENCE_FORCE = 50.0
"""y_ref of the free-rolling controller [N]"""
BAND = 0.05
"""a force within this share of its reference has settled [-]"""
FIT_RANGE = (0.1, USABLE_ROAD)
"""road displacement that is fitted [m]"""
SETTLED_BEFORE = f"over within the first {FIT_RANGE[0]:g} m: p1 and p2 not determined"
TOO_SLOW = "longer than the road: p1 and p2 not determined"
RATES = np.geomspace(0.1, 100.0, 61)
"""values of p2 that are tried before the search is refined [1/m]"""


@dataclass(frozen=True)
class ExponentialFit:
    """y(x) = p1 exp(-p2 x) + p3 (E.1); p1, p3 [N], p2 [1/m]; without p1 and p2, NaN, where no
    exponential can be seen in the fitted road."""

    p1: float
    p2: float
    p3: float
    rmse: float
    remark: str = ""
    """why p1 and p2 are not determined"""

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Fitted force [N] at road displacement `x` [m]."""
        if self.remark:
            return np.full(np.shape(x), self.p3)
        return self.p1 * np.exp(-self.p2 * np.asarray(x)) + self.p3

    def settles_at(self, reference: float = REFERENCE_FORCE, band: float = BAND) -> float:
        """Displacement from which |y_ref - y| <= band y_ref [m]; NaN when it never settles.

        The start of the fitted road, at the latest, where no exponential can be seen.
        """
        limit = band * abs(reference)
        if self.remark == SETTLED_BEFORE:
            return FIT_RANGE[0] if abs(self.p3 - reference) <= limit else math.nan
        room = limit - math.copysign(1.0, self.p1) * (self.p3 - reference)
        if abs(self.p3 - reference) > limit or self.p2 <= 0.0:
            return math.nan
        if self.p1 == 0.0 or abs(self.p1) <= room:
            return 0.0
        return math.log(abs(self.p1) / room) / self.p2 if room > 0.0 else math.inf


def fit_exponential(x: np.ndarray, y: np.ndarray) -> ExponentialFit:
    """Least squares fit of (E.1); p1 and p3 are linear, so only p2 is searched.

    Where the exponential is over before the fitted road, or longer than the road, p1 and p2 are
    not determined, and p3 is the mean force.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = (x >= FIT_RANGE[0]) & (x <= FIT_RANGE[1]) & np.isfinite(y)
    x, y = x[keep], y[keep]

    def solve(log_rate: float) -> tuple[float, np.ndarray]:
        basis = np.column_stack([np.exp(-math.exp(log_rate) * x), np.ones_like(x)])
        coefficients, *_ = np.linalg.lstsq(basis, y, rcond=None)
        return float(np.mean((basis @ coefficients - y) ** 2)), coefficients

    logs = np.log(RATES)
    best = int(np.argmin([solve(value)[0] for value in logs]))
    bounds = (logs[max(best - 1, 0)], logs[min(best + 1, logs.size - 1)])
    found = minimize_scalar(lambda v: solve(v)[0], bounds=bounds, method="bounded")
    cost, (p1, p3) = solve(float(found.x))
    p2, rmse = math.exp(found.x), math.sqrt(cost)
    if remark := _undetermined(p1, p2, rmse, x):
        return ExponentialFit(math.nan, math.nan, float(y.mean()), float(y.std()), remark)
    return ExponentialFit(float(p1), p2, float(p3), rmse)


def _undetermined(p1: float, p2: float, rmse: float, x: np.ndarray) -> str:
    """Why the fitted road (n,) does not show this exponential; empty when it does."""
    if abs(p1) * math.exp(-p2 * x[0]) < rmse or _at_the_end(p2):
        return SETTLED_BEFORE
    return TOO_SLOW if p2 * float(np.ptp(x)) < 1.0 else ""


def _at_the_end(p2: float) -> bool:
    """True when the search has ended at its highest rate."""
    return p2 > 0.99 * RATES[-1]
