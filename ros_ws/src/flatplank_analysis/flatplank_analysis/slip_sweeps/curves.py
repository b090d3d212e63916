# SPDX-License-Identifier: Apache-2.0
"""A force over a swept slip: its mean, its floor, and the Magic Formula's B, C, D, E of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import least_squares

from flatplank_analysis.discovery.sources.ranked import BY_NAME
from flatplank_analysis.slip_sweeps.conditions import BINS, FORCE, Condition
from flatplank_analysis.slip_sweeps.levels import SMOOTH

FEW = 3
"""samples; a bin with fewer is empty"""
COMMON = 0.4
"""share of the bins that two passes must share to be compared"""
Z90 = 1.645


@dataclass(frozen=True)
class Curve:
    """A force in bins of the slip; NaN where a bin is empty."""

    slip: np.ndarray
    """[rad] or [-]"""
    force: np.ndarray
    """[N]"""
    up: np.ndarray
    """force while the slip rises [N]"""
    down: np.ndarray
    """and while it falls [N]"""
    floor: float
    """how far the measurement can differ from a curve at the best [N]; NaN: not known"""
    floor_from: str
    """title of the source, in words"""


@dataclass(frozen=True)
class Formula:
    """y = D sin(C atan(B x - E (B x - atan(B x)))) + Sv, x = slip + Sh."""

    values: Mapping[str, float]
    """B [1/slip], C, D [N], E, Sh [slip], Sv [N]"""
    spread: Mapping[str, float]
    """half width of the 90 % interval"""
    rms: float
    """of the samples [N]"""

    @property
    def stiffness(self) -> float:
        """B C D [N per rad, or N]."""
        return self.values["B"] * self.values["C"] * self.values["D"]

    def known(self, name: str) -> bool:
        """Whether the sweep says the value to a half."""
        return self.spread[name] < 0.5 * abs(self.values[name])

    def __call__(self, slip: np.ndarray) -> np.ndarray:
        return _formula([self.values[k] for k in NAMES], slip)


NAMES = ("B", "C", "D", "E", "Sh", "Sv")


def curve_of(columns: Mapping[str, np.ndarray], condition: Condition) -> Curve:
    """The force of a condition over its slip."""
    rows = condition.samples
    slip, force = columns[condition.swept][rows], columns[FORCE[condition.swept]][rows]
    edges = np.linspace(slip.min(), slip.max(), BINS + 1)
    bins = np.clip(np.digitize(slip, edges) - 1, 0, BINS - 1)
    rising = np.gradient(median_filter(slip, min(SMOOTH, len(slip)), mode="nearest")) > 0.0
    half = np.searchsorted(rows, _break(rows)) if condition.visits > 1 else len(rows)
    first = np.arange(len(rows)) < half
    up, down = _means(bins, force, rising), _means(bins, force, ~rising)
    floor, source = _floor(bins, force, up, down, first if condition.visits > 1 else None)
    every = _means(bins, force, np.ones(len(rows), bool))
    return Curve(0.5 * (edges[1:] + edges[:-1]), every, up, down, floor, source)


def _break(rows: np.ndarray) -> int:
    """The sample with which the second visit begins."""
    return int(rows[int(np.argmax(np.diff(rows))) + 1])


def _means(bins: np.ndarray, values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    count = np.bincount(bins[chosen], minlength=BINS)
    total = np.bincount(bins[chosen], values[chosen], minlength=BINS)
    return np.where(count >= FEW, total / np.maximum(count, 1), np.nan)


def _floor(bins, force, up, down, first) -> tuple[float, str]:
    """Root mean square of what a mean curve leaves, from repeats or from up and down."""
    if first is not None:
        a, b = _means(bins, force, first), _means(bins, force, ~first)
        if np.isfinite(a - b).mean() > COMMON:
            return _half(a - b), BY_NAME["repeats"].title
    if np.isfinite(up - down).mean() > COMMON:
        return _half(up - down), BY_NAME["ways"].title
    return float("nan"), BY_NAME["nothing"].title


def _half(difference: np.ndarray) -> float:
    """Two halves that differ by d each lie d / 2 from their mean."""
    return float(0.5 * np.sqrt(np.nanmean(difference**2)))


def fit_formula(curve: Curve) -> Formula | None:
    """Least squares of the bins; None when there are too few."""
    good = np.isfinite(curve.force)
    x, y = curve.slip[good], curve.force[good]
    if len(x) < 8:
        return None
    size, width = float(np.abs(y).max()), float(np.abs(x).max())
    sign = float(np.sign(np.polyfit(x, y, 1)[0])) or 1.0
    scale = np.array([1.0 / width, 1.0, size, 1.0, 0.1 * width, 0.1 * size])
    low = np.array([0.2, 0.8, 0.3, -20.0, -3.0, -5.0]) * scale
    high = np.array([40.0, 2.2, 5.0, 1.0, 3.0, 5.0]) * scale

    def rest(p: np.ndarray) -> np.ndarray:
        return (_formula(p, x) - sign * y) / size

    starts = [np.array([b / width, 1.4, size, -0.5, 0.0, 0.0]) for b in (2.0, 5.0, 12.0)]
    found = min(
        (least_squares(rest, s, bounds=(low, high), x_scale=scale) for s in starts),
        key=lambda r: r.cost,
    )
    values = found.x * np.array([1.0, 1.0, sign, 1.0, 1.0, sign])
    return Formula(
        dict(zip(NAMES, map(float, values), strict=True)),
        dict(zip(NAMES, _spread(found, scale), strict=True)),
        float(size * np.sqrt(np.mean(found.fun**2))),
    )


def _spread(found, scale: np.ndarray) -> list[float]:
    """Half widths of the intervals; infinite where the sweep does not say."""
    free = max(len(found.fun) - len(found.x), 1)
    jac = found.jac * scale
    _, s, vt = np.linalg.svd(jac, full_matrices=False)
    weak = s < 1e-9 * s[0]
    s = np.where(weak, np.nan, s)
    variance = np.nansum((vt.T / s) ** 2, axis=1) * 2.0 * found.cost / free
    variance[np.any(np.abs(vt.T[:, weak]) > 0.1, axis=1)] = np.inf
    return [float(v) for v in Z90 * scale * np.sqrt(variance)]


def _formula(p, x: np.ndarray) -> np.ndarray:
    b, c, d, e, sh, sv = p
    bx = b * (x + sh)
    return d * np.sin(c * np.arctan(bx - e * (bx - np.arctan(bx)))) + sv
