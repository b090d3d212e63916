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
    F = K kappa (1 - q |kappa|) in the brush model. K is extrapolated, with a second pair of levels
    or, on one side, from zero and two levels. Fewer give the secant (see `slope_lack`).
    """
    pairs, side = _pairs(kappa), _side(kappa)
    if len(pairs) > 1:
        secants = [_secant(kappa, low, high) for low, high in pairs]
        reach = [_reach(kappa, low, high) for low, high in pairs]
        return (secants[0] * reach[1] - secants[1] * reach[0]) / (reach[1] - reach[0])
    if side:
        return _parabola(kappa, side)
    low, high = pairs[0] if pairs else (0, len(kappa) - 1)
    return _secant(kappa, low, high)


def slope_lack(kappa: np.ndarray) -> str:
    """What is missing for the slope at zero slip; empty when the levels tell it."""
    if len(_pairs(kappa)) > 1 or _side(kappa):
        return ""
    if _pairs(kappa):
        return "a second pair of slips, braking and driving"
    return "a run without slip and two small slips of one sign"


def curve_law(kappa: np.ndarray, force: np.ndarray) -> TableLaw:
    """Table through the levels (k,), force (k,) or (lanes, k), with its true slope at zero slip.

    Half-way between zero and its neighbours a point is put on F = F0 + K kappa (1 - q |kappa|).
    """
    zero = int(np.argmin(np.abs(kappa)))
    pairs, side = _pairs(kappa), _side(kappa)
    if abs(kappa[zero]) > NEAR_ZERO or (len(pairs) < 2 and not side):
        return table_law(kappa, force)
    values = np.atleast_2d(force)
    slope = values @ slope_weights(kappa)
    low, high = pairs[0] if len(pairs) > 1 else sorted(side[:2])
    secant = (values[:, high] - values[:, low]) / (kappa[high] - kappa[low])
    reach = max(abs(kappa[low]), abs(kappa[high]))
    bend = (slope - secant) / (_reach(kappa, low, high) if len(pairs) > 1 else reach)
    middle = values[:, zero] - slope * kappa[zero]
    points, added = [], []
    for level in {low, high} - {zero}:
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


def _side(kappa: np.ndarray) -> tuple[int, ...]:
    """Zero and the two levels next to it on the side that has two; empty without them."""
    zero = int(np.argmin(np.abs(kappa)))
    if abs(kappa[zero]) > NEAR_ZERO:
        return ()
    sides = (np.flatnonzero(kappa > NEAR_ZERO), np.flatnonzero(kappa < -NEAR_ZERO)[::-1])
    found = [side for side in sides if len(side) > 1]
    return (zero, *(int(i) for i in found[0][:2])) if found else ()


def _reach(kappa: np.ndarray, low: int, high: int) -> float:
    """Slip by which the secant of K kappa (1 - q |kappa|) is too low: K (1 - q reach)."""
    return float((kappa[high] ** 2 + kappa[low] ** 2) / (kappa[high] - kappa[low]))


def _secant(kappa: np.ndarray, low: int, high: int) -> np.ndarray:
    weights = np.zeros(len(kappa))
    weights[[low, high]] = np.array([-1.0, 1.0]) / (kappa[high] - kappa[low])
    return weights


def _parabola(kappa: np.ndarray, side: tuple[int, ...]) -> np.ndarray:
    """Slope at zero slip of the parabola through three levels."""
    weights = np.zeros(len(kappa))
    powers = np.vander(kappa[list(side)], 3, increasing=True)
    weights[list(side)] = np.linalg.solve(powers.T, np.array([0.0, 1.0, 0.0]))
    return weights


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
