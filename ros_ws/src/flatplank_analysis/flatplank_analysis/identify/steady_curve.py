# SPDX-License-Identifier: Apache-2.0
"""Steady force over slip of one condition (figure 7.7), and its slope at zero slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..models.steady_law import TableLaw, table_law
from .linear import LinearFit
from .runs import StepRun, by_level

NEAR_ZERO = 2e-3
"""Slips below this count as free rolling [-]."""


@dataclass(frozen=True)
class SteadyCurve:
    """F_ss over kappa: one point per slip level, repeats averaged."""

    kappa: np.ndarray
    """Mean actual slip per level (k,) [-]."""
    force: np.ndarray
    """Steady force per level (k,) [N]."""
    std_error: np.ndarray
    """Standard error per level (k,) [N]; NaN for a level without repeats."""
    repeats: np.ndarray
    """Number of runs per level (k,)."""

    def law(self) -> TableLaw:
        """As the look-up table of the model."""
        return curve_law(self.kappa, self.force)

    def slope_weights(self) -> np.ndarray:
        """Weights (k,) [1] of the forces in C_Fkappa, the slope in the limit of zero slip."""
        return slope_weights(self.kappa)


def slope_weights(kappa: np.ndarray) -> np.ndarray:
    """What each level's force contributes to the slope at zero slip (k,).

    The slope between the levels next to zero is too low, since the curve bends from the start:
    F = K kappa (1 - q |kappa|) in the brush model. With a second pair of levels K is extrapolated.
    """
    pairs = _pairs(kappa)
    if not pairs:
        weights = np.zeros(len(kappa))
        weights[[0, -1]] = np.array([-1.0, 1.0]) / (kappa[-1] - kappa[0])
        return weights
    secants, reach = [], []
    for low, high in pairs:
        secant = np.zeros(len(kappa))
        secant[[low, high]] = np.array([-1.0, 1.0]) / (kappa[high] - kappa[low])
        secants.append(secant)
        reach.append(0.5 * (kappa[high] - kappa[low]))
    if len(pairs) == 1:
        return secants[0]
    return (secants[0] * reach[1] - secants[1] * reach[0]) / (reach[1] - reach[0])


def curve_law(kappa: np.ndarray, force: np.ndarray) -> TableLaw:
    """Table through the levels (k,), force (k,) or (lanes, k), with its true slope at zero slip.

    Half-way between zero and its neighbours a point is put on F = F0 + K kappa (1 - q |kappa|).
    """
    zero = int(np.argmin(np.abs(kappa)))
    pairs = _pairs(kappa)
    if len(pairs) < 2 or abs(kappa[zero]) > NEAR_ZERO:
        return table_law(kappa, force)
    values = np.atleast_2d(force)
    slope = values @ slope_weights(kappa)
    low, high = pairs[0]
    secant = (values[:, high] - values[:, low]) / (kappa[high] - kappa[low])
    bend = (slope - secant) / (0.5 * (kappa[high] - kappa[low]))
    middle = values[:, zero] - slope * kappa[zero]
    points, added = [], []
    for level in (low, high):
        end, half = kappa[level], 0.5 * kappa[level]
        miss = values[:, level] - (middle + slope * end - bend * end * abs(end))
        points.append(half)
        added.append(middle + slope * half - bend * half * abs(half) + 0.5 * miss)
    slips = np.concatenate([kappa, points])
    order = np.argsort(slips)
    forces = np.hstack([values, np.array(added).T])[:, order]
    return table_law(slips[order], forces if np.ndim(force) > 1 else forces[0])


def _pairs(kappa: np.ndarray) -> list[tuple[int, int]]:
    """Up to two pairs of levels (braking, driving), the one next to zero first."""
    low = np.flatnonzero(kappa < -NEAR_ZERO)[::-1]
    high = np.flatnonzero(kappa > NEAR_ZERO)
    return [(int(i), int(j)) for i, j in zip(low[:2], high[:2], strict=False)]


def steady_curve(runs: Sequence[StepRun], fits: Sequence[LinearFit]) -> SteadyCurve:
    """Mean asymptote of the linear fits per slip level."""
    place = {id(run): fit.steady_force.value for run, fit in zip(runs, fits, strict=True)}
    groups = list(by_level(runs).values())
    forces = [np.array([place[id(m)] for m in members]) for members in groups]
    return SteadyCurve(
        kappa=np.array([np.mean([m.kappa for m in members]) for members in groups]),
        force=np.array([f.mean() for f in forces]),
        std_error=np.array(
            [f.std(ddof=1) / np.sqrt(len(f)) if len(f) > 1 else np.nan for f in forces]
        ),
        repeats=np.array([len(f) for f in forces]),
    )
