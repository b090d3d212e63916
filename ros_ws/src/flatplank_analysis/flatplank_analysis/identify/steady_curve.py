# SPDX-License-Identifier: Apache-2.0
"""Steady force over slip of one condition (figure 7.7), and its slope at zero slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..models.nonlinear import TableLaw, table_law
from ..starts import mean_over_starts, value_over_starts
from .linear import LinearFit
from .runs import StepRun, by_level

NEAR_ZERO = 2e-3
"""Slips below this count as free rolling [-]."""
FORM = 1.0 / 3.0
"""Standard error of the extrapolation to zero slip, as a share of the change by its last term."""


@dataclass(frozen=True)
class SteadyCurve:
    """F_ss over kappa: one point per slip level, repeats averaged."""

    kappa: np.ndarray
    """Mean actual slip per level (k,) [-]."""
    force: np.ndarray
    """Mean steady force per level (k,) [N]."""
    std_error: np.ndarray
    """Standard error per level (k,) [N]; NaN for a level without repeats."""
    repeats: np.ndarray
    """Number of runs per level (k,)."""

    def law(self) -> TableLaw:
        """The curve as the look-up table of the nonlinear model."""
        return curve_law(self.kappa, self.force)

    def slope(self) -> Slope:
        """C_Fkappa, the slope in the limit of zero slip, with its derivatives and error."""
        weights = slope_weights(self.kappa, self.force)
        plain = slope_weights(self.kappa, self.force, bend=0.0)
        form = FORM * abs(float((weights - plain) @ self.force))
        return Slope(float(weights @ self.force), weights, form)


@dataclass(frozen=True)
class Slope:
    """Slope of a steady curve at zero slip."""

    value: float
    """C_Fkappa [N]."""
    weights: np.ndarray
    """Derivative of the slope by the force of each level (k,) [1]."""
    form: float
    """Standard error [N] from the form of the curve between zero and its neighbours."""


def slope_weights(kappa: np.ndarray, force: np.ndarray, bend: float | None = None) -> np.ndarray:
    """Weights (..., k) [1] of each level's force (..., k) in the slope at zero slip.

    The slope between the levels next to zero is too low, because the curve bends from the start:
    in the brush model F = K kappa (1 - q |kappa| + (q kappa)^2 / 3) up to full sliding at 1/q
    (Pacejka 2012, section 3.2). K and q follow from a second pair of levels or, on one side, from
    zero and two levels; `bend` is q where it is given. Fewer levels give the secant (see
    `slope_lack`).
    """
    chords = _chords(kappa)
    force = np.asarray(force, float)
    if not chords:
        low, high = (_pairs(kappa) or [(0, len(kappa) - 1)])[0]
        return np.broadcast_to(_secant(kappa, low, high), force.shape)
    q = np.asarray(_bend(kappa, force) if bend is None else bend)[..., None]
    (r1, c1), (r2, c2) = (_reach(kappa, *chord) for chord in chords)
    first, second = (1.0 - q * r + q**2 * c / 3.0 for r, c in ((r1, c1), (r2, c2)))
    turn1, turn2 = (2.0 * q * c / 3.0 - r for r, c in ((r1, c1), (r2, c2)))
    near, far = (_secant(kappa, *chord) for chord in chords)
    return (turn2 * near - turn1 * far) / (first * turn2 - second * turn1)


def slope_lack(kappa: np.ndarray, force: np.ndarray) -> str:
    """Runs missing for the slope at zero slip; empty when the levels (k,) determine it."""
    chords = _chords(kappa)
    if not chords:
        pair = "a second pair of slips, braking and driving"
        return pair if _pairs(kappa) else "a run without slip and two small slips of one sign"
    reach = _reach(kappa, *chords[1])[0]
    if _bend(kappa, force) * reach < 1.0:
        return ""
    return f"smaller slips: at {100.0 * reach:.2g} % the whole contact slides"


def curve_law(kappa: np.ndarray, force: np.ndarray) -> TableLaw:
    """Table through the levels (k,), force (k,) or (sets, k), with its true slope at zero slip.

    Half-way between zero and its neighbours a point of the brush's curve is added.
    """
    zero, chords = int(np.argmin(np.abs(kappa))), _chords(kappa)
    if abs(kappa[zero]) > NEAR_ZERO or not chords:
        return table_law(kappa, force)
    values = np.atleast_2d(force)
    q = _bend(kappa, values)
    slope = np.sum(slope_weights(kappa, values) * values, axis=1)
    middle = values[:, zero] - slope * kappa[zero]

    def brush(slip: float) -> np.ndarray:
        return middle + slope * slip * (1.0 - q * abs(slip) + (q * slip) ** 2 / 3.0)

    points, added = [], []
    for level in set(chords[0]) - {zero}:
        end, half = kappa[level], 0.5 * kappa[level]
        points.append(half)
        added.append(brush(half) + 0.5 * (values[:, level] - brush(end)))
    slips = np.concatenate([kappa, points])
    order = np.argsort(slips)
    forces = np.hstack([values, np.array(added).T])[:, order]
    return table_law(slips[order], forces if np.ndim(force) > 1 else forces[0])


def _bend(kappa: np.ndarray, force: np.ndarray) -> np.ndarray:
    """q of the brush (...,) [1] from the forces (..., k); limited to full sliding at far
    levels."""
    near, far = _chords(kappa)
    (r1, c1), (r2, c2) = _reach(kappa, *near), _reach(kappa, *far)
    one, two = (force @ _secant(kappa, *chord) for chord in (near, far))
    sliding = (c2 / 3.0) / (r2**2 - r1 * r2 + c1 / 3.0)
    ratio = np.clip(np.divide(two, one, out=np.ones_like(two), where=one != 0.0), None, r2 / r1)
    a, b, c = (c2 - ratio * c1) / 3.0, r2 - ratio * r1, 1.0 - ratio
    root = 2.0 * c / (b + np.sqrt(np.maximum(b**2 - 4.0 * a * c, 0.0)))
    return np.where(ratio > sliding, np.minimum(root, 1.0 / r2), 1.0 / r2)


def _chords(kappa: np.ndarray) -> tuple[tuple[int, int], ...]:
    """Levels (low, high) of the two chords that determine slope and bend, the near one first."""
    pairs, side = _pairs(kappa), _side(kappa)
    if len(pairs) > 1:
        return pairs[0], pairs[1]
    return tuple((min(side[0], i), max(side[0], i)) for i in side[1:])


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


def _reach(kappa: np.ndarray, low: int, high: int) -> tuple[float, float]:
    """Chord slopes of |kappa| kappa [-] and of kappa^3 [-], relative to that of kappa."""
    one, two = kappa[low], kappa[high]
    span = two - one
    return float((two * abs(two) - one * abs(one)) / span), float((two**3 - one**3) / span)


def _secant(kappa: np.ndarray, low: int, high: int) -> np.ndarray:
    weights = np.zeros(len(kappa))
    weights[[low, high]] = np.array([-1.0, 1.0]) / (kappa[high] - kappa[low])
    return weights


def steady_curve(runs: Sequence[StepRun], fits: Sequence[LinearFit]) -> SteadyCurve:
    """Mean asymptote of the linear fits per slip level."""
    place = {id(run): fit.steady_force.value for run, fit in zip(runs, fits, strict=True)}
    groups = list(by_level(runs).values())
    starts = [[m.start for m in members] for members in groups]
    both = list(zip(groups, starts, strict=True))
    forces = [value_over_starts([place[id(m)] for m in members], s) for members, s in both]
    return SteadyCurve(
        kappa=np.array([mean_over_starts([m.kappa for m in members], s) for members, s in both]),
        force=np.array([f.value for f in forces]),
        std_error=np.array([f.std_error for f in forces]),
        repeats=np.array([f.runs for f in forces]),
    )
