# SPDX-License-Identifier: Apache-2.0
"""Results of a fitted output: standard errors, bounds, what is undetermined, second solutions.

K_xk = Fz (PKX1 + PKX2 dfz) exp(PKX3 dfz) takes the same values at three loads with PKX2 of either
sign, so three loads leave two answers far apart, each with a small error (twins).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_data.wording import behind, plain

from ..lateral import zero_warning
from ..least_squares import Solution, linearise, solve
from ..noise import Covariance, PropagatedErrors, run_covariance
from ..results import Confusion, Estimate, Fit
from .information import SHOW, confusions, describe_levels, grain, levels_of, proposals
from .lack import BY_LAW, lack_of_fit, restated
from .points import SteadyPoints
from .problem import WEAK, OutputProblem

SHIFTED = ("PKY1", "PHY1", "PVY1", "QHZ1")
"""Coefficients that change with the steering zero."""


@dataclass(frozen=True)
class FittedOutput:
    """A fitted output, whose coefficients are held in the fits of later outputs."""

    problem: OutputProblem
    x: np.ndarray
    runs: np.ndarray
    run_contributions: np.ndarray
    """Error of the coefficients by run (runs, p); 0 for those on a bound."""


def _propagated(
    problem: OutputProblem, x: np.ndarray, earlier: Sequence[FittedOutput]
) -> PropagatedErrors | None:
    """Effect of the errors of earlier outputs on the rows of this one."""
    base = problem.at(x)
    runs, parts = [], []
    for held in earlier:
        limits, free = held.problem.limits, held.problem.free
        moved = replace(problem, base=base, free=free, limits=limits, priors={})
        rows = _rows(moved, held.x, problem.points)
        if np.any(rows):
            runs.append(held.runs)
            parts.append(held.run_contributions @ rows.T)
    return PropagatedErrors(np.concatenate(runs), np.vstack(parts)) if parts else None


def report(
    output: str, problem: OutputProblem, solution: Solution, earlier: Sequence[FittedOutput]
) -> tuple[Fit, FittedOutput]:
    """Estimates with standard errors and bounds, and statements on what is undetermined."""
    n, names = len(problem.points), problem.free
    held = solution.at_bound
    jac, residual = solution.jacobian[:n], solution.residual[:n]
    weak = np.diag(1.0 / (WEAK * problem.sizes) ** 2)
    propagated = _propagated(problem, solution.x, earlier)
    prior = problem.prior_information(held) + weak[np.ix_(~held, ~held)]
    cover = run_covariance(jac[:, ~held], residual, problem.points.run, prior, propagated)

    def offers() -> list:
        return proposals(problem.points, lambda p: _rows(problem, solution.x, p), problem.reach)

    # including coefficients at a bound: holding one of a group that cannot be separated makes
    # the others look determined
    known = np.sqrt(problem.prior_information(np.zeros_like(held)))
    correlation = np.eye(len(names))
    correlation[np.ix_(~held, ~held)] = cover.correlation
    stacked = np.vstack([jac, known])
    errors = np.zeros(len(names))
    errors[~held] = cover.std_error
    found, open_mask = confusions(names, stacked, problem.sizes, correlation, offers, errors)
    lack = lack_of_fit(problem.points, residual, int(np.count_nonzero(~held)))
    if lack is not None:

        def determined(mask: np.ndarray) -> set[str]:
            rows = np.vstack([jac[mask] / lack.scatter, known])
            unknown = confusions(names, rows, problem.sizes, correlation, list)[1]
            return {name for name, is_open in zip(names, unknown, strict=True) if not is_open}

        found = [restated(c, lack, problem.points, determined) for c in found]
    twin = twin_of(problem, solution)
    if twin is not None:
        found = [c for c in found if set(c.names) != set(twin.names)]
        found.append(twin)
        open_mask |= np.isin(names, twin.names)
    stated = np.array([name in problem.priors for name in names])
    open_mask = (open_mask & ~stated)[~held]
    warning = zero_warning(np.degrees(problem.points.alpha).tolist())
    estimates = tuple(
        e.with_note(warning if e.name in SHIFTED else "")
        for e in _estimates(problem, solution, cover, open_mask, found)
    )
    error = residual * problem.error_scale()
    fit = Fit(
        model=f"mf:{output}",
        estimates=estimates,
        correlation=cover.correlation,
        confusions=tuple(found),
        rmse=float(np.sqrt(np.mean(error**2))),
        runs=len(np.unique(problem.points.run)),
        converged=solution.converged,
    )
    run_contributions = np.zeros((len(cover.runs), len(names)))
    run_contributions[:, ~held] = cover.run_contributions
    return fit, FittedOutput(problem, solution.x, cover.runs, run_contributions)


def _estimates(
    problem: OutputProblem, solution: Solution, cover: Covariance, open_mask: np.ndarray,
    found: Sequence[Confusion],
) -> tuple[Estimate, ...]:  # fmt: skip
    out = []
    by_law = {name for c in found if BY_LAW in c.statement for name in c.names}
    spare = len(np.unique(problem.points.run)) - int(np.count_nonzero(~open_mask))
    rows = iter(zip(cover.std_error, cover.dof, open_mask, strict=True))
    for name, value, edge in zip(problem.free, solution.x.tolist(), solution.edges, strict=True):
        unit = problem.limit(name).unit
        if edge:
            note = "rests on its bound"
            out.append(Estimate(name, value, unit, at_bound=edge, determined=False, note=note))
            continue
        error, dof, is_open = next(rows)
        size = behind(plain(error, 2), unit)
        cause = BY_LAW if name in by_law else "by these data"
        note = f"not determined {cause}: ± {size}" if is_open else ""
        if not is_open and spare < 1 and name not in problem.priors:
            error, note = float("nan"), "as many coefficients as runs: no error without repeats"
        known = not bool(is_open)
        out.append(Estimate(name, value, unit, float(error), float(dof), "", known, note=note))
    return tuple(out)


def _rows(problem: OutputProblem, x: np.ndarray, points: SteadyPoints) -> np.ndarray:
    """Scaled Jacobian rows of points that were not measured (m, p)."""

    def scaled(sets: np.ndarray) -> np.ndarray:
        return problem.predict(sets, points) / problem.error_scale(points)

    low, high = problem.bounds
    return linearise(scaled, x, low, high, problem.sizes)


PAIR = ("PKX2", "PKX3")
"""Coefficients of K_xk that may have two solutions."""
AS_GOOD = 9.2
"""Cost difference below which twins are not distinguished: odds of 100 to 1 are 2 ln 100."""
SURELY = 1.0
"""Number of standard deviations by which the expected cost difference must lie above AS_GOOD: 1 is
five of six repetitions of the campaign. With less, the intervals of those campaigns that happen to
exclude the twin miss the truth too often."""
APART = 0.5
"""Twins closer than this, in relevant sizes, are one solution."""


def better_twin(problem: OutputProblem, found: Solution) -> Solution:
    """The better of both solutions; where they are equally good, the one with smaller PKX3."""
    other = _other(problem, found)
    if other is None or other.cost > found.cost + AS_GOOD:
        return found
    if other.cost < found.cost - AS_GOOD:
        return other
    place = problem.free.index(PAIR[1])
    return min(found, other, key=lambda s: abs(float(s.x[place])))


def twin_of(problem: OutputProblem, found: Solution) -> Confusion | None:
    """The second solution, with a load that excludes it; None if these data surely exclude it."""
    other = _other(problem, found)
    if other is None or _distinguishable(problem, found, other):
        return None
    values = ", ".join(f"{name} = {other.x[problem.free.index(name)]:.3g}" for name in PAIR)
    have = describe_levels(problem.points, "fz")
    as_well = other.cost - found.cost <= AS_GOOD
    how = "that fits as well" if as_well else "that only the noise of these runs excludes"
    text = f"{PAIR[0]} and {PAIR[1]} have a second solution ({values}) {how} with {have}"
    load = _deciding_load(problem, found.x, other.x)
    remedy = f"measure {SHOW['fz'](load)}" if load else "fix one in the fit file"
    return Confusion(PAIR, 1.0, text, remedy)


def _distinguishable(problem: OutputProblem, found: Solution, other: Solution) -> bool:
    """Whether the other solution fits worse, here and in most repetitions of the campaign.

    With predictions D apart (in standard deviations of the scatter) the cost difference of the two
    solutions is D^2 +- 2 D.
    """
    rows = problem.residuals(np.array([found.x, other.x]))[:, : len(problem.points)]
    apart = float(np.linalg.norm(rows[1] - rows[0]))
    return other.cost - found.cost > AS_GOOD and apart**2 - 2.0 * SURELY * apart > AS_GOOD


def _other(problem: OutputProblem, found: Solution) -> Solution | None:
    """Search from the mirrored pair; None when it ends at the same solution."""
    if not set(PAIR) <= set(problem.free) or not set(PAIR).isdisjoint(problem.priors):
        return None
    i, j = (problem.free.index(name) for name in PAIR)
    if found.at_bound[i] or found.at_bound[j]:
        return None
    low, high = problem.bounds
    start = found.x.copy()
    start[i], start[j] = -start[i], _mirrored(problem, found.x)
    # the weak prior must not decide between the two: it is centred at the start of the search
    moved = replace(problem, base=problem.at(start))
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
    c = problem.at(x)
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

    apart = 2.0 * grain(problem.points, "fz")
    new = [v for v in problem.reach["fz"] if np.all(np.abs(have - v) > apart)]
    return max(new, key=gap, default=None)
