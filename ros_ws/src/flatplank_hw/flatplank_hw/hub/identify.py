# SPDX-License-Identifier: Apache-2.0
"""Identifies the parasitic signal from a three-turn run of the unloaded wheel (Appendix C)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from flatplank_hw.hub.parasitic import INDEX, ParasiticFit, Sine

WINDOW = (2.0 * math.pi, 4.0 * math.pi)
"""wheel angle from the start that is fitted, 360..720 deg, at steady speed [rad]"""
MIN_SAMPLES = 100


def identify_fit(
    wheel_angle: ArrayLike, volts: ArrayLike, mounting: str, date: str
) -> ParasiticFit:
    """Fit (C.1) per channel by least squares.

    wheel_angle: shape (n,) [rad] of the encoder's own counter; volts: shape (n, 6), C1..C6 [V].
    """
    angle = np.asarray(wheel_angle, dtype=float)
    table = np.asarray(volts, dtype=float)
    if table.shape != (angle.size, 6):
        raise ValueError(
            f"parasitic run: volts have shape {table.shape}, wanted ({angle.size}, 6)"
        )
    if not (np.isfinite(angle).all() and np.isfinite(table).all()):
        raise ValueError("parasitic run: NaN in angle or volts; record the run again")
    turned = np.abs(angle - angle[0]) if angle.size else angle
    inside = (turned >= WINDOW[0]) & (turned <= WINDOW[1])
    reached = float(turned.max(initial=0.0))
    if reached < WINDOW[1] or np.count_nonzero(inside) < MIN_SAMPLES:
        raise ValueError(
            f"parasitic run: the wheel turned {math.degrees(reached):.0f} deg and 720 deg are "
            "needed: turn it by 1080 deg without load"
        )
    x = angle[inside]
    sines = tuple(_fit(x, table[inside, column]) for column in INDEX)
    return ParasiticFit(mounting, date, sines)


def _fit(x: NDArray[np.float64], y: NDArray[np.float64]) -> Sine:
    """Fit all four parameters from no sine at B = 1."""
    scale = max(float(np.std(y)), 1e-9)
    mean = float(np.mean(y)) / scale

    # sine and cosine parts instead of A and C avoid the singularity at A = 0
    def residual(p: NDArray[np.float64]) -> NDArray[np.float64]:
        return p[0] * np.sin(p[2] * x) + p[1] * np.cos(p[2] * x) + p[3] - y / scale

    free = math.inf
    bounds = [-free, -free, 0.8, -free], [free, free, 1.2, free]
    result = least_squares(residual, [0.0, 0.0, 1.0, mean], bounds=bounds)
    s, c, b, d = result.x
    rms = float(np.sqrt(np.mean(result.fun**2))) * scale
    return Sine(scale * math.hypot(s, c), float(b), math.atan2(c, s), scale * float(d), rms)
