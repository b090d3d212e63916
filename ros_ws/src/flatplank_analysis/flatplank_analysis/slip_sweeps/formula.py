# SPDX-License-Identifier: Apache-2.0
"""Magic Formula B, C, D, E of a curve, with the interval of each value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from flatplank_analysis.identify.results import NORMAL_90
from flatplank_analysis.slip_sweeps.curves import Curve, bin_means
from flatplank_tire.magic_formula.state import curve_angle


@dataclass(frozen=True)
class Formula:
    """y = D sin(C atan(B x - E (B x - atan(B x)))) + Sv, x = slip + Sh."""

    values: Mapping[str, float]
    """B [1/slip], C, D [N], E, Sh [slip], Sv [N]"""
    spread: Mapping[str, float]
    """half width of the 90 % interval"""
    rms: float
    """root mean square error of the bins [N]"""

    @property
    def stiffness(self) -> float:
        """B C D [N per rad, or N]."""
        return self.values["B"] * self.values["C"] * self.values["D"]

    def known(self, name: str) -> bool:
        """True when the half width of the interval is below half of the value."""
        return self.spread[name] < 0.5 * abs(self.values[name])

    def __call__(self, slip: np.ndarray) -> np.ndarray:
        return _formula([self.values[k] for k in NAMES], slip)


NAMES = ("B", "C", "D", "E", "Sh", "Sv")
LEAST_BINS = 8
"""least number of filled bins for the six values of the formula"""
TYPICAL = (1.0, 1.0, 1.0, 1.0, 0.1, 0.1)
"""sizes of the values, in units of the largest slip and the largest force"""
LOW, HIGH = (0.2, 0.8, 0.3, -20.0, -0.3, -0.5), (40.0, 2.2, 5.0, 1.0, 0.3, 0.5)
"""bounds in the same units"""
STARTS = tuple((b, 1.4, 1.0, -0.5, 0.0, 0.0) for b in (2.0, 5.0, 12.0))
"""start values in the same units"""
DEPENDENT = 0.1
"""share of a value in a direction that the sweep does not determine, above which it is open"""
SINGULAR = 1e-9
"""relative singular value of such a direction"""


def fit_formula(curve: Curve) -> Formula | None:
    """Least squares of the bins; None when there are too few.

    The formula is evaluated at every sample and averaged over the samples of a bin, as the force
    was.
    """
    good = np.isfinite(curve.force)
    x, y = curve.slip[good], curve.force[good]
    if len(x) < LEAST_BINS:
        return None
    size, width = float(np.abs(y).max()), float(np.abs(x).max())
    sign = float(np.sign(np.polyfit(x, y, 1)[0])) or 1.0
    unit = np.array([1.0 / width, 1.0, size, 1.0, width, size])
    low, high, scale = (unit * values for values in (LOW, HIGH, TYPICAL))

    def rest(p: np.ndarray) -> np.ndarray:
        return (bin_means(curve.bins, _formula(p, curve.samples))[good] - sign * y) / size

    found = min(
        (least_squares(rest, unit * s, bounds=(low, high), x_scale=scale) for s in STARTS),
        key=lambda r: r.cost,
    )
    values = found.x * np.array([1.0, 1.0, sign, 1.0, 1.0, sign])
    return Formula(
        dict(zip(NAMES, map(float, values), strict=True)),
        dict(zip(NAMES, _spread(found, scale), strict=True)),
        float(size * np.sqrt(np.mean(found.fun**2))),
    )


def _spread(found, scale: np.ndarray) -> list[float]:
    """Half widths of the intervals; infinite where the sweep does not determine a value."""
    free = max(len(found.fun) - len(found.x), 1)
    jac = found.jac * scale
    _, s, vt = np.linalg.svd(jac, full_matrices=False)
    weak = s < SINGULAR * s[0]
    s = np.where(weak, np.nan, s)
    variance = np.nansum((vt.T / s) ** 2, axis=1) * 2.0 * found.cost / free
    variance[np.any(np.abs(vt.T[:, weak]) > DEPENDENT, axis=1)] = np.inf
    return [float(v) for v in NORMAL_90 * scale * np.sqrt(variance)]


def _formula(p, x: np.ndarray) -> np.ndarray:
    b, c, d, e, sh, sv = p
    return d * np.sin(curve_angle(c, b, e, x + sh)) + sv
