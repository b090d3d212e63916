# SPDX-License-Identifier: Apache-2.0
"""Settling distance of a free-rolling run, thesis Appendix E."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from flatplank_data.machine import USABLE_ROAD

REFERENCE_FORCE = 50.0
"""y_ref of the free-rolling controller [N]"""
BAND = 0.05
FIT_RANGE = (0.1, USABLE_ROAD)
"""road displacement that is fitted [m]"""
RATES = np.geomspace(0.1, 100.0, 61)
"""p2 that are tried before the search is refined [1/m]"""


@dataclass(frozen=True)
class ExponentialFit:
    """y(x) = p1 exp(-p2 x) + p3 (E.1); p1, p3 [N], p2 [1/m]."""

    p1: float
    p2: float
    p3: float
    rmse: float

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Fitted force [N] at road displacement `x` [m]."""
        return self.p1 * np.exp(-self.p2 * np.asarray(x)) + self.p3

    def settles_at(self, reference: float = REFERENCE_FORCE, band: float = BAND) -> float:
        """Displacement from which |y_ref - y| <= band y_ref [m]; NaN when that is never so."""
        limit = band * abs(reference)
        room = limit - math.copysign(1.0, self.p1) * (self.p3 - reference)
        if abs(self.p3 - reference) > limit or self.p2 <= 0.0:
            return math.nan
        if self.p1 == 0.0 or abs(self.p1) <= room:
            return 0.0
        return math.log(abs(self.p1) / room) / self.p2 if room > 0.0 else math.inf


def fit_exponential(
    x: np.ndarray, y: np.ndarray, fit_range: tuple[float, float] = FIT_RANGE
) -> ExponentialFit:
    """Least squares fit of (E.1); p1 and p3 are linear, so only p2 is searched."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = (x >= fit_range[0]) & (x <= fit_range[1]) & np.isfinite(y)
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
    return ExponentialFit(float(p1), math.exp(found.x), float(p3), math.sqrt(cost))


def settling_distance(
    x: np.ndarray, y: np.ndarray, reference: float = REFERENCE_FORCE, band: float = BAND
) -> float:
    """Displacement [m] at which the fitted force stays within the band of the reference [N]."""
    return fit_exponential(x, y).settles_at(reference, band)
