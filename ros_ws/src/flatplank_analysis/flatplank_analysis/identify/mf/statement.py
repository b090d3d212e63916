# SPDX-License-Identifier: Apache-2.0
"""What a fitted output says: standard errors, bounds, and what its points leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..information import confusions
from ..least_squares import Solution, linearise
from ..results import Estimate, Fit
from ..steering_zero import zero_warning
from ..uncertainty import Carried, Covariance, run_covariance
from .candidates import proposals
from .points import SteadyPoints
from .problem import WEAK, OutputProblem
from .twins import twin_of

SHIFTED = ("PKY1", "PHY1", "PVY1", "QHZ1")
"""coefficients that a steering zero changes"""


@dataclass(frozen=True)
class Held:
    """An output that was fitted before: its coefficients are held in the later ones."""

    problem: OutputProblem
    x: np.ndarray
    runs: np.ndarray
    brought: np.ndarray
    """Error of the coefficients by run (runs, p); 0 for those on a bound."""


def _carried(problem: OutputProblem, x: np.ndarray, earlier: Sequence[Held]) -> Carried | None:
    """What the errors of earlier outputs do to the rows of this one."""
    base = problem.base.replaced(dict(zip(problem.free, x, strict=True)))
    runs, parts = [], []
    for held in earlier:
        limits, free = held.problem.limits, held.problem.free
        moved = replace(problem, base=base, free=free, limits=limits, priors={})
        rows = _rows(moved, held.x, problem.points)
        if np.any(rows):
            runs.append(held.runs)
            parts.append(held.brought @ rows.T)
    return Carried(np.concatenate(runs), np.vstack(parts)) if parts else None


def report(
    output: str, problem: OutputProblem, solution: Solution, earlier: Sequence[Held]
) -> tuple[Fit, Held]:
    """Standard errors, bounds, and what the points leave open."""
    n, names = len(problem.points), problem.free
    held = solution.at_bound
    jac, residual = solution.jacobian[:n], solution.residual[:n]
    weak = np.diag(1.0 / (WEAK * problem.sizes) ** 2)
    carried = _carried(problem, solution.x, earlier)
    prior = problem.prior_information(held) + weak[np.ix_(~held, ~held)]
    cover = run_covariance(jac[:, ~held], residual, problem.points.run, prior, carried)

    def offers() -> list:
        return proposals(problem.points, lambda p: _rows(problem, solution.x, p))

    # With the coefficients that rest on a bound: holding one of a group that cannot be told apart
    # makes the others look determined.
    known = np.sqrt(problem.prior_information(np.zeros_like(held)))
    correlation = np.eye(len(names))
    correlation[np.ix_(~held, ~held)] = cover.correlation
    told = np.vstack([jac, known])
    errors = np.zeros(len(names))
    errors[~held] = cover.std_error
    found, open_mask = confusions(names, told, problem.sizes, correlation, offers, errors)
    twin = twin_of(problem, solution)
    if twin is not None:
        found = [c for c in found if set(c.names) != set(twin.statement.names)]
        found.append(twin.statement)
        open_mask |= np.isin(names, twin.statement.names)
    stated = np.array([name in problem.priors for name in names])
    open_mask = (open_mask & ~stated)[~held]
    warning = zero_warning(np.degrees(problem.points.alpha).tolist())
    estimates = tuple(
        e.with_note(warning if e.name in SHIFTED else "")
        for e in _estimates(problem, solution, cover, held, open_mask)
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
    brought = np.zeros((len(cover.runs), len(names)))
    brought[:, ~held] = cover.brought
    return fit, Held(problem, solution.x, cover.runs, brought)


def _estimates(
    problem: OutputProblem,
    solution: Solution,
    cover: Covariance,
    held: np.ndarray,
    open_mask: np.ndarray,
) -> tuple[Estimate, ...]:
    out, place = [], 0
    spare = len(np.unique(problem.points.run)) - int(np.count_nonzero(~open_mask))
    for i, name in enumerate(problem.free):
        value, unit = float(solution.x[i]), problem.limit(name).unit
        if held[i]:
            edge = "lower" if solution.at_lower[i] else "upper"
            out.append(
                Estimate(
                    name, value, unit, at_bound=edge, determined=False, note="rests on its bound"
                )
            )
            continue
        error, dof = float(cover.std_error[place]), float(cover.dof[place])
        is_open = bool(open_mask[place])
        note = "not determined by these data" if is_open else ""
        if not is_open and spare < 1 and name not in problem.priors:
            error, note = float("nan"), "as many coefficients as runs: no error without repeats"
        out.append(Estimate(name, value, unit, error, dof, determined=not is_open, note=note))
        place += 1
    return tuple(out)


def _rows(problem: OutputProblem, x: np.ndarray, points: SteadyPoints) -> np.ndarray:
    """Scaled Jacobian rows of points that were not measured (m, p)."""

    def scaled(lanes: np.ndarray) -> np.ndarray:
        return problem.predict(lanes, points) / problem.error_scale(points)

    low = np.array([problem.limit(n).lower for n in problem.free])
    high = np.array([problem.limit(n).upper for n in problem.free])
    return linearise(scaled, x, low, high, problem.sizes)[1]
