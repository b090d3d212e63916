# SPDX-License-Identifier: Apache-2.0
"""A straight line through readings: what every one of these calibrations is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Line(NamedTuple):
    """y = offset + slope x, with standard errors."""

    slope: float
    offset: float
    slope_error: float
    offset_error: float
    residual: float
    """rms of what is left, in the unit of y"""
    points: int


def fit_line(pairs: Sequence[tuple[float, float]], reading: float = 0.0) -> Line:
    """Least squares through (x, y); `reading`: uncertainty of one y, which counts when two points
    leave no residual."""
    x = np.array([p[0] for p in pairs], float)
    y = np.array([p[1] for p in pairs], float)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("calibration: a reading is no number; read it again")
    if x.size < 2 or np.ptp(x) <= 0.0:
        raise ValueError("calibration: give at least two different points, as in 0:0.1,1000:996")
    centre = x - x.mean()
    spread = float(centre @ centre)
    slope = float(centre @ y) / spread
    offset = float(y.mean() - slope * x.mean())
    left = y - offset - slope * x
    freedom = x.size - 2
    scatter = math.sqrt(float(left @ left) / freedom) if freedom else 0.0
    sigma = max(scatter, reading)
    return Line(
        slope, offset, sigma / math.sqrt(spread),
        sigma * math.sqrt(1.0 / x.size + x.mean() ** 2 / spread),
        float(np.sqrt(np.mean(left**2))), int(x.size),
    )  # fmt: skip
