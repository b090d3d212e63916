# SPDX-License-Identifier: Apache-2.0
"""Second solutions: K_xk = Fz (PKX1 + PKX2 dfz) exp(PKX3 dfz) takes the same values at three loads
with PKX2 of either sign, so three loads leave two answers far apart, each with a small error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..least_squares import Solution, solve
from ..results import Confusion
from .candidates import GRAIN, REACH, SHOW, describe_levels, levels_of
from .problem import OutputProblem

PAIR = ("PKX2", "PKX3")
AS_GOOD = 9.2
"""Twins whose costs differ by less are not told apart: odds of 100 to 1 are 2 ln 100"""
SURELY = 1.0
"""Standard deviations: AS_GOOD is passed in five of six repeats of the campaign. Where fewer pass,
those that do are a selection of noises, and their intervals hold too rarely"""
APART = 0.5
"""Twins closer than this, in sizes that matter, are one solution"""


@dataclass(frozen=True)
class Twin:
    """Another solution that the points cannot exclude."""

    solution: Solution
    statement: Confusion


def better_twin(problem: OutputProblem, found: Solution) -> Solution:
    """The better of both solutions; where they are equally good, that of the smaller PKX3."""
    other = _other(problem, found)
    if other is None or other.cost > found.cost + AS_GOOD:
        return found
    if other.cost < found.cost - AS_GOOD:
        return other
    place = problem.free.index(PAIR[1])
    return min(found, other, key=lambda s: abs(float(s.x[place])))


def twin_of(problem: OutputProblem, found: Solution) -> Twin | None:
    """The second solution, when these data do not surely exclude it, with the load that would."""
    other = _other(problem, found)
    if other is None or _told_apart(problem, found, other):
        return None
    values = ", ".join(f"{name} = {other.x[problem.free.index(name)]:.3g}" for name in PAIR)
    have = describe_levels(problem.points, "fz")
    as_well = other.cost - found.cost <= AS_GOOD
    how = "that fits as well" if as_well else "that only the noise of these runs excludes"
    text = f"{PAIR[0]} and {PAIR[1]} have a second solution ({values}) {how} with {have}"
    load = _deciding_load(problem, found.x, other.x)
    remedy = f"measure {SHOW['fz'](load)}" if load else "fix one in the fit file"
    return Twin(other, Confusion(PAIR, 1.0, text, remedy))


def _told_apart(problem: OutputProblem, found: Solution, other: Solution) -> bool:
    """Whether the other solution fits worse, here and in most repeats of the campaign.

    With predictions D apart (in standard deviations of the scatter) the costs of the wrong and the
    right one differ by D^2 +- 2 D.
    """
    lanes = problem.residuals(np.array([found.x, other.x]))[:, : len(problem.points)]
    apart = float(np.linalg.norm(lanes[1] - lanes[0]))
    return other.cost - found.cost > AS_GOOD and apart**2 - 2.0 * SURELY * apart > AS_GOOD


def _other(problem: OutputProblem, found: Solution) -> Solution | None:
    """Search from the mirrored pair; None when it leads back to the same place."""
    if not set(PAIR) <= set(problem.free) or not set(PAIR).isdisjoint(problem.priors):
        return None
    i, j = (problem.free.index(name) for name in PAIR)
    if found.at_bound[i] or found.at_bound[j]:
        return None
    low = np.array([problem.limit(n).lower for n in problem.free])
    high = np.array([problem.limit(n).upper for n in problem.free])
    start = found.x.copy()
    start[i], start[j] = -start[i], _mirrored(problem, found.x)
    # The weak prior must not judge between the two: it is centred where the search began.
    moved = replace(
        problem, base=problem.base.replaced(dict(zip(problem.free, start, strict=True)))
    )
    other = solve(moved.residuals, np.clip(start, low, high), low, high, problem.sizes, 1e-8, 120)
    away = np.abs(other.x[[i, j]] - found.x[[i, j]]) / problem.sizes[[i, j]]
    if np.max(away) < APART or np.any(other.at_bound[[i, j]]):
        return None
    residual = problem.residuals(other.x[None])[0]
    n = len(problem.points)
    return replace(other, residual=np.append(residual[:n], found.residual[n:]))


def _mirrored(problem: OutputProblem, x: np.ndarray) -> float:
    """PKX3 that keeps K_xk over the loads of the data when PKX2 changes its sign."""
    dfz, pkx1, pkx2 = _slope_terms(problem, x)
    part = pkx2 * dfz / max(pkx1, 1e-6)
    inside = (np.abs(part) < 0.95) & (np.abs(dfz) > 1e-3)
    pkx3 = float(x[problem.free.index(PAIR[1])])
    if not inside.any():
        return pkx3
    shift = np.log1p(part[inside]) - np.log1p(-part[inside])
    return pkx3 + float(shift @ dfz[inside] / (dfz[inside] @ dfz[inside]))


def _slope_terms(problem: OutputProblem, x: np.ndarray) -> tuple[np.ndarray, float, float]:
    c = problem.base.replaced(dict(zip(problem.free, x, strict=True)))
    nominal = float(c.LFZO * c.FNOMIN)
    return levels_of(problem.points, "fz") / nominal - 1.0, float(c.PKX1), float(c.PKX2)


def _deciding_load(problem: OutputProblem, one: np.ndarray, two: np.ndarray) -> float | None:
    """Load that the bench can set and at which the slip stiffnesses differ most [N]."""
    nominal = float(problem.base.LFZO * problem.base.FNOMIN)
    have = levels_of(problem.points, "fz")

    def gap(load: float) -> float:
        dfz = load / nominal - 1.0
        values = []
        for x in (one, two):
            _, pkx1, pkx2 = _slope_terms(problem, x)
            pkx3 = float(x[problem.free.index(PAIR[1])])
            values.append(load * (pkx1 + pkx2 * dfz) * np.exp(pkx3 * dfz))
        return abs(values[1] - values[0])

    new = [v for v in REACH["fz"] if np.all(np.abs(have - v) > 2.0 * GRAIN["fz"])]
    return max(new, key=gap, default=None)
