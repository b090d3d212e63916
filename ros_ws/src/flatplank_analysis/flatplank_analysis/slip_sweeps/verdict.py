# SPDX-License-Identifier: Apache-2.0
"""Whether the error of a tire file is more than scatter: the F test of error and floor.

Two passes a and b through the same slip have the scatters n_a and n_b. The error of an exact file
is (n_a + n_b) / 2, the floor is (n_a - n_b) / 2: both have the same variance and are independent,
so that the ratio of their squares follows an F distribution. What else the passes differ in (the
relaxation of the tire between rising and falling slip) makes the floor larger, and the verdict
milder.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import f as f_distribution

RISK = 0.01
"""chance that an exact tire file fails in any condition of a sweep file [-]"""
RELAXATION = 4
"""coefficients of a polynomial in the slip that rising and falling slip differ by: relaxation"""
LONGEST = 0.9
"""largest autocorrelation of neighbouring bins [-]: beyond it scatter and curve look alike"""


def chance_of(error: float, floor: float, freedom: float) -> float:
    """Chance that scatter alone makes an error as large as this [-]; NaN without a floor."""
    if not floor > 0.0:
        return float("nan")
    return float(f_distribution.sf((error / floor) ** 2, freedom, freedom))


def fails(chances: Sequence[float]) -> np.ndarray:
    """Conditions (n,) in which the file fails: an exact one fails in any with the chance RISK."""
    return np.asarray(chances) < 1.0 - (1.0 - RISK) ** (1.0 / max(len(chances), 1))


def degrees_of_freedom(difference: np.ndarray, count: np.ndarray, smooth: int = 0) -> float:
    """Degrees of freedom of the mean square of a difference of two curves (bins,) [N].

    Satterthwaite's: bins with fewer samples (count) scatter more, and neighbouring bins scatter
    alike where the scatter has a memory. smooth: coefficients of the polynomial that is no
    scatter. NaN where too few bins are common.
    """
    good = np.flatnonzero(np.isfinite(difference))
    if len(good) < smooth + 3:
        return float("nan")
    variance = 1.0 / count[good]
    rest = difference[good] / np.sqrt(variance)
    if smooth:
        rest = rest - np.polyval(np.polyfit(good, rest, smooth - 1), good)
    alike = _memory(rest, smooth) ** np.abs(good[:, None] - good[None, :])
    weights = variance[:, None] * variance[None, :]
    whole = float(variance.sum() ** 2 / (weights * alike**2).sum())
    return max(whole * (1.0 - smooth / len(good)), 1.0)


def _memory(rest: np.ndarray, smooth: int) -> float:
    """Autocorrelation of neighbouring bins, 0 or more [-].

    The removal of a polynomial lowers it by about (coefficients / bins) (1 + autocorrelation).
    """
    n, power = len(rest), float(rest @ rest)
    found = float(rest[1:] @ rest[:-1]) / power if power > 0.0 else 0.0
    return float(np.clip((n * found + smooth) / (n - smooth), 0.0, LONGEST))
