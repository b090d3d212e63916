# SPDX-License-Identifier: Apache-2.0
"""Linear fits of all runs of a condition: mean of repeats, noise, scatter from run to run.

Forces that turn with the wheel cancel in the mean of repeats from several start angles (section
6.2), while the fit of a single run of small slip may follow them to an absurd relaxation length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..starts import by_start, mean_over_starts
from .linear import BEFORE, BEFORE_WEIGHT, LinearFit, first_order_rise, linear_run
from .noise import ARNoise, fit_noise, repeat_differences
from .results import Confusion, Estimate, plain_condition, to_plain
from .runs import StepRun, by_level


@dataclass(frozen=True)
class MeanResponse:
    """Linear model of the mean of some repeats."""

    fit: LinearFit
    std_error: np.ndarray
    """Standard errors of sigma [m], asymptote and start force [N], from the scatter (3,)."""


def with_equal_starts(runs: Sequence[StepRun]) -> list[StepRun]:
    """Runs in which every start angle of a level has equal weight.

    Where a level has several start angles with different numbers of runs, those of one angle are
    averaged: otherwise the mean would follow the angle that was repeated most.
    """
    out: list[StepRun] = []
    for members in by_level(runs).values():
        starts = by_start(members, [run.start for run in members])
        uneven = len({len(same) for same in starts}) > 1
        out += [_averaged(same) for same in starts] if uneven else members
    return out if len(out) < len(runs) else list(runs)


def _averaged(runs: Sequence[StepRun]) -> StepRun:
    if len(runs) == 1:
        return runs[0]
    x = _shared_distance(runs)
    columns = {
        name: _mean([np.interp(x, run.distance, getattr(run, name)) for run in runs], runs)
        for name in ("fx", "fy", "mz", "fz", "slip")
    }
    return replace(
        runs[0], distance=x, kappa=float(_mean([run.kappa for run in runs], runs)), **columns
    )


def _mean(values: Sequence[Any], runs: Sequence[StepRun]) -> Any:
    return mean_over_starts(values, [run.start for run in runs])


def has_mean(runs: Sequence[StepRun]) -> bool:
    """True when these repeats started at different angles and have a slip above 0.2 %."""
    return len({run.start for run in runs}) > 1 and min(abs(run.kappa) for run in runs) > 2e-3


def mean_response(runs: Sequence[StepRun]) -> MeanResponse:
    """Fit (7.11) to the mean of repeats; its error follows from the single runs (linearised)."""
    runs = with_equal_starts(runs)
    fit = mean_fit(runs)
    x, force = _together(runs)
    weight = np.where(x < 0.0, np.sqrt(BEFORE_WEIGHT), 1.0)
    pulls = (weight * (force - fit.response(x))) @ np.linalg.pinv(_jacobian(fit, x, weight)).T
    count = len(runs)
    spread = pulls - pulls.mean(axis=0)
    return MeanResponse(fit, np.sqrt(np.sum(spread**2, axis=0) / (count * (count - 1.0))))


def mean_fit(runs: Sequence[StepRun]) -> LinearFit:
    """Fit (7.11) to the mean of repeats over the start angles."""
    x, force = _together(runs)
    return linear_run(x, _mean(force, runs), float(_mean([run.kappa for run in runs], runs)))


def _together(runs: Sequence[StepRun]) -> tuple[np.ndarray, np.ndarray]:
    """Distance (n,) [m] that all runs cover, and their Fx there (runs, n) [N]."""
    x = _shared_distance(runs)
    x = x[x >= -BEFORE]
    return x, np.array([np.interp(x, run.distance, run.fx) for run in runs])


def shared_fits(runs: Sequence[StepRun]) -> list[LinearFit]:
    """Fit of every run; repeats share the relaxation length of their mean, if it was fitted."""
    found: dict[int, LinearFit] = {}
    for members in by_level(runs).values():
        mean = mean_response(members).fit if has_mean(members) else None
        for run in members:
            found[id(run)] = run.linear() if mean is None else _own(run, mean)
    return [found[id(run)] for run in runs]


def asymptotes(runs: Sequence[StepRun]) -> np.ndarray:
    """Steady force of every run [N], with the relaxation length that its repeats share (n,)."""
    return np.array([fit.steady_force.value for fit in shared_fits(runs)])


def _own(run: StepRun, mean: LinearFit) -> LinearFit:
    """The fit of the mean, with steady and start force fitted to this run alone."""
    x = run.distance
    keep = x >= -BEFORE
    rise = first_order_rise(x[keep], mean.sigma.value)
    weight = np.where(x[keep] < 0.0, np.sqrt(BEFORE_WEIGHT), 1.0)
    basis = weight[:, None] * np.column_stack([rise, 1.0 - rise])
    measured = weight * run.fx[keep]
    if mean.start_force.fixed:
        basis = basis[:, :1]
    steady, first = np.append(np.linalg.lstsq(basis, measured, rcond=None)[0], 0.0)[:2]
    return replace(
        mean,
        steady_force=replace(mean.steady_force, value=float(steady)),
        start_force=replace(mean.start_force, value=float(first)),
    )


def _shared_distance(runs: Sequence[StepRun]) -> np.ndarray:
    """Distance (n,) [m] that all runs cover."""
    first = max(float(run.distance[0]) for run in runs)
    last = min(float(run.distance[-1]) for run in runs)
    return runs[0].distance[(runs[0].distance >= first) & (runs[0].distance <= last)]


def _jacobian(fit: LinearFit, x: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Derivatives of the response by sigma, asymptote and start force, weighted (n, 3)."""
    sigma, change = fit.sigma.value, fit.steady_force.value - fit.start_force.value
    s = np.maximum(x, 0.0) / sigma
    rest = np.exp(-s)
    return weight[:, None] * np.column_stack([-change * s * rest / sigma, 1.0 - rest, rest])


QUANTITIES = ("sigma", "slip_stiffness", "steady_force")
NOT_REPEATED = Confusion(
    ("run-to-run scatter", "noise"),
    1.0,
    "no slip level was repeated: scatter between runs is not in the standard errors",
    "repeat each slip level at another start angle",
)


@dataclass(frozen=True)
class LinearLevel:
    """Mean of the repeats of one slip level."""

    level: float
    """Nominal slip [-]."""
    kappa: float
    """Mean actual slip [-]."""
    sigma: Estimate
    slip_stiffness: Estimate
    steady_force: Estimate
    rmse: float
    """Root mean square over the repeats in the transient part [N] (Table 7.1)."""
    repeats: int

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        plain = {n: to_plain(getattr(self, n)) for n in ("level", "kappa", "rmse", "repeats")}
        return plain | {n: getattr(self, n).to_json() for n in QUANTITIES}


@dataclass(frozen=True)
class LinearCondition:
    """All runs of one operating condition under the linear model."""

    operating_point: Any
    levels: tuple[LinearLevel, ...]
    fits: tuple[LinearFit, ...]
    """Per run, in the order given; standard errors contain noise and run-to-run scatter."""
    names: tuple[str, ...]
    scatter: dict[str, float]
    """Run-to-run scatter, relative standard deviation of each quantity."""
    noise: ARNoise
    confusions: tuple[Confusion, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        runs = [{"run": n} | f.to_json() for n, f in zip(self.names, self.fits, strict=True)]
        return {
            "condition": plain_condition(self.operating_point),
            "levels": [level.to_json() for level in self.levels],
            "runs": runs,
            "scatter": to_plain(self.scatter),
            "confusions": [c.to_json() for c in self.confusions],
        }


def fit_linear(runs: Sequence[StepRun]) -> LinearCondition:
    """Linear transient model for every run of one condition."""
    first = [run.linear() for run in runs]
    groups = [[runs.index(m) for m in members] for members in by_level(runs).values()]
    noise = _noise(first, groups)
    fits = [run.linear(noise) for run in runs]
    scatter = {q: _scatter(fits, groups, q) for q in QUANTITIES}
    fits = [_widened(fit, scatter) for fit in fits]
    dof = float(sum(len(g) - 1 for g in groups))
    levels = tuple(_level(runs, fits, g, dof, scatter) for g in groups)
    return LinearCondition(
        operating_point=runs[0].operating_point,
        levels=levels,
        fits=tuple(fits),
        names=tuple(run.name for run in runs),
        scatter=scatter,
        noise=noise,
        confusions=_confusions(runs, groups),
    )


def _noise(fits: Sequence[LinearFit], groups: Sequence[Sequence[int]]) -> ARNoise:
    """Noise from differences between repeats after the fit; from the residuals without repeats."""
    length = min(len(f.residual) for f in fits)
    stacks = [np.array([fits[i].residual[-length:] for i in g]) for g in groups]
    return fit_noise(repeat_differences(stacks) or [f.residual for f in fits])


def _scatter(fits: Sequence[LinearFit], groups: Sequence[Sequence[int]], name: str) -> float:
    """Relative standard deviation between runs beyond what noise explains, over all levels."""
    squares, freedom = 0.0, 0
    for group in groups:
        estimates = [getattr(fits[i], name) for i in group]
        if len(estimates) < 2 or not all(e.determined and abs(e.value) > 0.0 for e in estimates):
            continue
        values = np.array([e.value for e in estimates])
        noise = np.mean([e.std_error**2 for e in estimates])
        spread = np.sum((values - values.mean()) ** 2) - (len(values) - 1) * noise
        squares += spread / values.mean() ** 2
        freedom += len(values) - 1
    return float(np.sqrt(max(squares, 0.0) / freedom)) if freedom else float("nan")


def _widened(fit: LinearFit, scatter: dict[str, float]) -> LinearFit:
    changes: dict[str, Any] = {}
    for name in QUANTITIES:
        estimate: Estimate = getattr(fit, name)
        extra = np.nan_to_num(scatter[name]) * abs(estimate.value)
        if estimate.determined:
            error = float(np.hypot(estimate.std_error, extra))
            changes[name] = replace(estimate, std_error=error)
    return replace(fit, **changes)


def _level(
    runs: Sequence[StepRun],
    fits: Sequence[LinearFit],
    group: Sequence[int],
    dof: float,
    scatter: dict[str, float],
) -> LinearLevel:
    means: dict[str, Estimate] = {}
    members = [runs[i] for i in group]
    for name in QUANTITIES:
        estimates = [getattr(fits[i], name) for i in group]
        values = np.array([e.value for e in estimates])
        error = float(np.sqrt(np.sum([e.std_error**2 for e in estimates])) / len(values))
        freedom = dof if np.isfinite(scatter[name]) and dof > 0 else estimates[0].dof
        means[name] = replace(
            estimates[0],
            value=float(_mean(values, members)),
            std_error=error,
            dof=freedom,
            at_bound=next((e.at_bound for e in estimates if e.at_bound), ""),
        )
    if has_mean(members):
        means |= _of_mean(members)
    errors = [fits[i].rmse_transient ** 2 for i in group]
    return LinearLevel(
        level=runs[group[0]].level,
        kappa=float(_mean([run.kappa for run in members], members)),
        rmse=float(np.sqrt(np.mean(errors))),
        repeats=len(group),
        **means,
    )


def _of_mean(runs: Sequence[StepRun]) -> dict[str, Estimate]:
    """Estimates from the mean response; the error from the scatter of these runs alone."""
    found = mean_response(runs)
    fit, (sigma, steady, _) = found.fit, found.std_error
    errors = {"sigma": sigma, "slip_stiffness": steady / abs(fit.kappa), "steady_force": steady}
    dof = float(len(with_equal_starts(runs)) - 1)
    return {
        name: replace(getattr(fit, name), std_error=float(error), dof=dof)
        for name, error in errors.items()
    }


def _confusions(runs: Sequence[StepRun], groups: Sequence[Sequence[int]]) -> tuple[Confusion, ...]:
    if all(len(g) < 2 for g in groups):
        return (NOT_REPEATED,)
    if len({run.start for run in runs}) < 2:
        text = "one start angle only: an error that turns with the wheel looks the same in every "
        text += "run and cannot be told from the steady force"
        names = ("steady_force", "once-per-turn error")
        remedy = "repeat the slips at a start angle of 120 deg"
        return (Confusion(names, 1.0, text, remedy),)
    return ()
