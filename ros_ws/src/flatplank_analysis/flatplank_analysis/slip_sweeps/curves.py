# SPDX-License-Identifier: Apache-2.0
"""A force or moment over a swept slip: mean curve, floor, and where a tire file fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from flatplank_analysis.discovery.sources import BY_NAME
from flatplank_analysis.slip_sweeps.conditions import BINS, FORCE, SMOOTH, SweepCondition
from flatplank_analysis.slip_sweeps.tir_signs import CONVENTIONS, READ, TirSigns
from flatplank_analysis.slip_sweeps.verdict import RELAXATION, chance_of, degrees_of_freedom
from flatplank_tire.magic_formula import steady_forces
from flatplank_tire.tir import TirFile

FEW = 3
"""least number of samples of a bin; a bin with fewer is empty"""
COMMON = 0.4
"""least share of common bins for a comparison of two passes"""


@dataclass(frozen=True)
class Curve:
    """A force [N] or moment [Nm] in bins of the slip, (BINS,); NaN where a bin is empty."""

    bins: np.ndarray
    """bin of each sample, shape (samples,)"""
    samples: np.ndarray
    """slip of each sample [rad] or [-], shape (samples,)"""
    rising: np.ndarray
    """samples at which the slip rises, shape (samples,)"""
    slip: np.ndarray
    """mean slip of the samples of a bin [rad] or [-]"""
    force: np.ndarray
    """its mean over the samples of a bin"""
    up: np.ndarray
    """its mean while the slip rises"""
    down: np.ndarray
    """its mean while the slip falls"""
    floor: float
    """smallest error that any curve can have, in the same unit; NaN: not known"""
    floor_from: str
    """source of the floor, as text"""
    freedom: float
    """degrees of freedom of the floor; NaN without a floor"""


def curve_of(
    columns: Mapping[str, np.ndarray], condition: SweepCondition, channel: str | None = None
) -> Curve:
    """A channel of a condition over its slip; by default the force of the slip."""
    rows = condition.samples
    slip, force = columns[condition.swept][rows], columns[channel or FORCE[condition.swept]][rows]
    edges = np.linspace(slip.min(), slip.max(), BINS + 1)
    bins = np.clip(np.digitize(slip, edges) - 1, 0, BINS - 1)
    rising = rises(slip)
    first = None
    if condition.visits > 1:
        # repeats begin after the largest gap between sample indices
        first = np.arange(len(rows)) <= np.argmax(np.diff(rows))
    up, down = bin_means(bins, force, rising), bin_means(bins, force, ~rising)
    floor = _floor(bins, force, up, down, first)
    return Curve(
        bins, slip, rising, bin_means(bins, slip), bin_means(bins, force), up, down, *floor
    )


def rises(slip: np.ndarray) -> np.ndarray:
    """Samples (n,): true where the slip rises, or is held after it rose."""
    step = np.gradient(median_filter(slip, min(SMOOTH, len(slip)), mode="nearest"))
    moved = np.flatnonzero(step)
    if not len(moved):
        return np.ones(len(slip), dtype=bool)
    last = np.maximum(np.searchsorted(moved, np.arange(len(slip)), side="right") - 1, 0)
    return step[moved[last]] > 0.0


def bin_means(
    bins: np.ndarray, values: np.ndarray, chosen: np.ndarray | slice = slice(None)
) -> np.ndarray:
    """Mean of the chosen samples in each bin, shape (BINS,); NaN in a bin with fewer than FEW."""
    count = np.bincount(bins[chosen], minlength=BINS)
    total = np.bincount(bins[chosen], values[chosen], minlength=BINS)
    return np.where(count >= FEW, total / np.maximum(count, 1), np.nan)


def _floor(bins, force, up, down, first) -> tuple[float, str, float]:
    """Floor of a mean curve [N], its source, and its degrees of freedom: from repeats, else from
    rising and falling slip."""
    count = np.bincount(bins, minlength=BINS)
    if first is not None:
        a, b = bin_means(bins, force, first), bin_means(bins, force, ~first)
        if np.isfinite(a - b).mean() > COMMON:
            return _half(a - b), BY_NAME["repeats"].title, degrees_of_freedom(a - b, count)
    if np.isfinite(up - down).mean() > COMMON:
        freedom = degrees_of_freedom(up - down, count, RELAXATION)
        return _half(up - down), BY_NAME["ways"].title, freedom
    return float("nan"), BY_NAME["nothing"].title, float("nan")


def _half(difference: np.ndarray) -> float:
    """Root mean square distance from the mean of two curves with this difference."""
    return float(0.5 * np.sqrt(np.nanmean(difference**2)))


@dataclass(frozen=True)
class Failure:
    """Error of a tire file in one condition."""

    error: float
    """root mean square of the mean curve [N], of a moment [Nm]"""
    share: float
    """error relative to the largest force or moment of the condition [-]"""
    modelled: np.ndarray
    """what the file says in the bins of the curve, in the same unit"""
    worst_slip: float
    """slip of the largest error [rad, -]"""
    worst: float
    """largest error: measured minus modelled, in the same unit"""
    chance: float
    """chance that the scatter alone makes an error as large; NaN without a floor"""


def failures(
    columns: Mapping[str, np.ndarray],
    conditions: Sequence[SweepCondition],
    curves: Sequence[Curve],
    tir: TirFile,
    signs: TirSigns = CONVENTIONS[READ],
    channel: str | None = None,
) -> list[Failure]:
    """Error of a tire file per condition; evaluated at every sample, then averaged in bins.

    channel: of the curves; by default the force of the slip. Mz has the sign of Fy: in every
    convention the side force acts behind the middle of the contact.
    """
    found = []
    for condition, curve in zip(conditions, curves, strict=True):
        rows = condition.samples
        get = {
            name: columns[name][rows] if name in columns else 0.0
            for name in ("kappa", "alpha", "gamma")
        }
        get["alpha"], get["gamma"] = signs.alpha * get["alpha"], signs.gamma * get["gamma"]
        pressure = columns["pressure"][rows] if "pressure" in columns else None
        speed = np.abs(columns["speed"][rows]) if "speed" in columns else 1.0
        forces = steady_forces(
            tir.coefficients, columns["fz"][rows], **get, pressure=pressure,
            vx=np.maximum(speed, 0.01),
        )  # fmt: skip
        axis, sign = {"fx": (0, 1), "fy": (1, signs.fy), "mz": (2, signs.fy)}[
            channel or FORCE[condition.swept]
        ]
        modelled = sign * forces[axis]
        found.append(_failure(curve, modelled))
    return found


def _failure(curve: Curve, modelled: np.ndarray) -> Failure:
    mean = bin_means(curve.bins, modelled)
    off = curve.force - mean
    at = int(np.nanargmax(np.abs(off)))
    error = float(np.sqrt(np.nanmean(off**2)))
    return Failure(
        error,
        error / float(np.nanmax(np.abs(curve.force))),
        mean,
        float(curve.slip[at]),
        float(off[at]),
        chance_of(error, curve.floor, curve.freedom),
    )
