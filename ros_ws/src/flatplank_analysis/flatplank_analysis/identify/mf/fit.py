# SPDX-License-Identifier: Apache-2.0
"""Magic Formula identification in ordered stages, and once more jointly per output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...errors import FlatplankError
from ...models.magic_formula import Coefficients
from ...models.tir import TirFile
from ..information import confusions
from ..least_squares import Solution, linearise
from ..quality import relative_error
from ..results import Confusion, Estimate, Fit
from ..uncertainty import Carried, Covariance, run_covariance
from .candidates import describe_levels, levels_of, proposals
from .parameters import COEFFICIENTS, Coefficient
from .points import SteadyPoints
from .problem import OutputProblem, Prior
from .stages import STAGES, Stage
from .twins import better_twin, twin_of

JOINT_ORDER = ("rho", "a", "b", "cx", "cy", "re", "fx", "fy", "mz")


@dataclass(frozen=True)
class MFSettings:
    """What a fit file may change."""

    stages: tuple[str, ...] = tuple(STAGES)
    fixed: Mapping[str, float] = field(default_factory=dict)
    free: tuple[str, ...] = ()
    """Coefficients that are free beyond those of the stages (in the stage of their output)."""
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    priors: Mapping[str, Prior] = field(default_factory=dict)
    weights: Mapping[str, float] = field(default_factory=dict)
    """Output -> weight against the other outputs' default."""
    joint: bool = True
    """Refit all coefficients of an output together at the end."""


@dataclass(frozen=True)
class MFFit:
    """A fitted tire: the file to use, and one `Fit` per output."""

    tir: TirFile
    fits: Mapping[str, Fit]
    relative_errors: Mapping[str, float]
    """Output -> e_r of (7.28)."""
    skipped: tuple[str, ...] = ()
    """Stages for which there were no data, and why."""

    @property
    def estimates(self) -> dict[str, Estimate]:
        """All estimates by name."""
        return {e.name: e for fit in self.fits.values() for e in fit.estimates}

    @property
    def confusions(self) -> tuple[Confusion, ...]:
        """All statements on what cannot be told apart."""
        return tuple(c for fit in self.fits.values() for c in fit.confusions)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "model": "mf",
            "coefficients": {k: float(v) for k, v in self.tir.values.items()},
            "fits": {k: f.to_json() for k, f in self.fits.items()},
            "relative_errors": {k: float(v) for k, v in self.relative_errors.items()},
            "skipped": list(self.skipped),
        }


def fit_magic_formula(
    points: SteadyPoints, tir: TirFile, settings: MFSettings | None = None
) -> MFFit:
    """Fit the stages in order, then every output jointly; `tir` gives all that is not fitted."""
    settings = settings or MFSettings()
    base = tir.coefficients.replaced(settings.fixed)
    touched: dict[str, list[str]] = {}
    skipped: list[str] = []
    solved: dict[str, tuple[OutputProblem, Solution]] = {}
    for name in settings.stages:
        if name not in STAGES:
            raise FlatplankError(
                f"no stage {name}", "fit settings", f"stages are {', '.join(STAGES)}"
            )
        stage = STAGES[name]
        chosen = points.rows(stage.select(points, base))
        for output, names in stage.outputs.items():
            free = _free(names.split(), output, settings, touched)
            data = chosen.with_output(output)
            reason = _obstacle(stage, output, free, data)
            if reason:
                skipped.append(f"{name}: {reason}")
                continue
            problem, solution = _solve(output, data, free, base, settings)
            base = base.replaced(dict(zip(problem.free, solution.x, strict=True)))
            touched.setdefault(output, []).extend(free)
            solved[output] = (problem, solution)
    if settings.joint:
        base, solved = _jointly(points, touched, base, settings)
    fits: dict[str, Fit] = {}
    earlier: list[Held] = []
    for output in (k for k in JOINT_ORDER if k in solved):
        fits[output], own = _report(output, *solved[output], earlier)
        earlier.append(own)
    names = [n for v in touched.values() for n in v]
    changed = {n: float(getattr(base, n)) for n in names} | dict(settings.fixed)
    errors = {
        k: relative_error(p.points.measured[k], p.predict(s.x[None])[0])
        for k, (p, s) in solved.items()
    }
    return MFFit(tir.replaced(changed), fits, errors, tuple(skipped))


def _obstacle(stage: Stage, output: str, free: Sequence[str], data: SteadyPoints) -> str:
    """Why this stage cannot be fitted to these points; empty when it can."""
    if not free:
        return f"all coefficients of {output} are fixed"
    if len(data) < 2:
        return f"{'one' if len(data) else 'no'} measurement of {output}"
    for axis in (*stage.needs, *stage.each.get(output, ())):
        if len(levels_of(data, axis)) < 2:
            told = describe_levels(data, axis)
            return f"{', '.join(free)} not determined by {told}; measure a second one"
    return ""


def _free(
    names: Sequence[str], output: str, settings: MFSettings, touched: Mapping[str, list[str]]
) -> list[str]:
    """Free coefficients of a stage; extra ones join the first stage that has their output."""
    extra = [] if touched.get(output) else [n for n in settings.free if _output_of(n) == output]
    wanted = dict.fromkeys([*names, *extra])
    done = touched.get(output, [])
    return [n for n in wanted if n not in settings.fixed and n not in done]


def _output_of(name: str) -> str:
    if name not in COEFFICIENTS:
        raise FlatplankError(
            f"{name} cannot be fitted", "fit settings", "see the coefficient table"
        )
    for stage in STAGES.values():
        for output, names in stage.outputs.items():
            if name in names.split():
                return output
    kinds = {"X": "fx", "Y": "fy", "Z": "mz"}
    return kinds.get(name.rstrip("0123456789")[-1], "rho" if name == "Q_FZ2" else "mz")


def _solve(
    output: str,
    data: SteadyPoints,
    free: Sequence[str],
    base: Coefficients,
    settings: MFSettings,
    broadly: bool = True,
) -> tuple[OutputProblem, Solution]:
    limits = {n: _limit(n, settings) for n in free}
    priors = {n: p for n, p in settings.priors.items() if n in free}
    weight = settings.weights.get(output, 1.0)
    problem = OutputProblem(output, data, tuple(free), base, limits, priors, weight)
    solution = problem.solve(broadly)
    scatter = _scatter(problem, solution)
    start = base.replaced(dict(zip(free, solution.x, strict=True)))
    again = replace(problem, base=start, scatter=scatter)
    return again, better_twin(again, again.solve())


def _scatter(problem: OutputProblem, solution: Solution) -> float:
    """Residual scatter in units of the first guess, never below a thousandth of it."""
    n = len(problem.points)
    left = max(n - len(problem.free), 1)
    found = float(np.sqrt(np.sum(solution.residual[:n] ** 2) / left))
    return max(found * problem.weight, 1e-3)


def _limit(name: str, settings: MFSettings) -> Coefficient:
    limit = COEFFICIENTS[name]
    if name not in settings.bounds:
        return limit
    low, high = settings.bounds[name]
    start = min(max(limit.start, low), high)
    return limit._replace(start=start, lower=low, upper=high)


def _jointly(
    points: SteadyPoints,
    touched: Mapping[str, list[str]],
    base: Coefficients,
    settings: MFSettings,
) -> tuple[Coefficients, dict[str, tuple[OutputProblem, Solution]]]:
    solved = {}
    for output in JOINT_ORDER:
        if output not in touched:
            continue
        data = points.with_output(output)
        problem, solution = _solve(output, data, touched[output], base, settings)
        base = base.replaced(dict(zip(problem.free, solution.x, strict=True)))
        solved[output] = (problem, solution)
    return base, solved


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


def _report(
    output: str, problem: OutputProblem, solution: Solution, earlier: Sequence[Held]
) -> tuple[Fit, Held]:
    """Standard errors, bounds, and what the points leave open."""
    n, names = len(problem.points), problem.free
    held = solution.at_bound
    jac, residual = solution.jacobian[:n], solution.residual[:n]
    weak = np.diag(1.0 / (10.0 * problem.sizes) ** 2)
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
    estimates = _estimates(problem, solution, cover, held, open_mask)
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
