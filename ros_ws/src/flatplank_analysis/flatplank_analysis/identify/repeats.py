# SPDX-License-Identifier: Apache-2.0
"""Linear fits of all runs of a condition: noise from repeats, scatter from run to run, means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .linear import LinearFit, linear_run
from .mean_response import balanced, has_mean, mean_response
from .noise import ARNoise, fit_noise, repeat_differences
from .results import Confusion, Estimate, plain_condition, to_plain
from .runs import StepRun, by_level

QUANTITIES = ("sigma", "slip_stiffness", "steady_force")


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
    """Transient part, quadratic mean over the repeats [N] (Table 7.1)."""
    repeats: int

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        plain = {n: to_plain(getattr(self, n)) for n in ("level", "kappa", "rmse", "repeats")}
        return plain | {n: getattr(self, n).to_json() for n in QUANTITIES}


@dataclass(frozen=True)
class LinearCondition:
    """All runs of one operating condition under the linear model."""

    condition: Any
    levels: tuple[LinearLevel, ...]
    fits: tuple[LinearFit, ...]
    """Per run, in the order given; standard errors hold noise and run-to-run scatter."""
    names: tuple[str, ...]
    scatter: dict[str, float]
    """Run-to-run scatter, relative standard deviation of each quantity."""
    noise: ARNoise
    confusions: tuple[Confusion, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        runs = [{"run": n} | f.to_json() for n, f in zip(self.names, self.fits, strict=True)]
        return {
            "condition": plain_condition(self.condition),
            "levels": [level.to_json() for level in self.levels],
            "runs": runs,
            "scatter": to_plain(self.scatter),
            "confusions": [c.to_json() for c in self.confusions],
        }


def fit_linear(runs: Sequence[StepRun], output: str = "fx") -> LinearCondition:
    """Linear transient model for every run of one condition, Fx over kappa or Fy over alpha."""
    first = [run.linear(output) for run in runs]
    groups = [[runs.index(m) for m in members] for members in by_level(runs).values()]
    noise = _noise(first, groups)
    fits = [_again(run, output, noise) for run in runs]
    scatter = {q: _scatter(fits, groups, q) for q in QUANTITIES}
    fits = [_widened(fit, scatter) for fit in fits]
    dof = float(sum(len(g) - 1 for g in groups))
    levels = tuple(_level(runs, fits, g, dof, scatter, output) for g in groups)
    return LinearCondition(
        condition=runs[0].condition,
        levels=levels,
        fits=tuple(fits),
        names=tuple(run.name for run in runs),
        scatter=scatter,
        noise=noise,
        confusions=_confusions(runs, groups),
    )


def _again(run: StepRun, output: str, noise: ARNoise) -> LinearFit:
    slip = run.kappa if output == "fx" else run.alpha
    return linear_run(run.distance, getattr(run, output), slip, noise=noise)


def _noise(fits: Sequence[LinearFit], groups: Sequence[Sequence[int]]) -> ARNoise:
    """From differences between repeats after the fit; from the residuals without repeats."""
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
    changes = {}
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
    output: str = "fx",
) -> LinearLevel:
    means: dict[str, Estimate] = {}
    for name in QUANTITIES:
        estimates = [getattr(fits[i], name) for i in group]
        values = np.array([e.value for e in estimates])
        error = float(np.sqrt(np.sum([e.std_error**2 for e in estimates])) / len(values))
        freedom = dof if np.isfinite(scatter[name]) and dof > 0 else estimates[0].dof
        means[name] = replace(
            estimates[0],
            value=float(values.mean()),
            std_error=error,
            dof=freedom,
            at_bound=next((e.at_bound for e in estimates if e.at_bound), ""),
        )
    members = [runs[i] for i in group]
    if has_mean(members, output):
        means |= _of_mean(members, output)
    errors = [fits[i].rmse_transient ** 2 for i in group]
    return LinearLevel(
        level=runs[group[0]].level,
        kappa=float(np.mean([runs[i].kappa for i in group])),
        rmse=float(np.sqrt(np.mean(errors))),
        repeats=len(group),
        **means,
    )


def _of_mean(runs: Sequence[StepRun], output: str) -> dict[str, Estimate]:
    """Estimates from the mean response; the error from the scatter of these runs alone."""
    found = mean_response(runs, output)
    fit, (sigma, steady, _) = found.fit, found.std_error
    errors = {"sigma": sigma, "slip_stiffness": steady / abs(fit.kappa), "steady_force": steady}
    dof = float(len(balanced(runs)) - 1)
    return {
        name: replace(getattr(fit, name), std_error=float(error), dof=dof)
        for name, error in errors.items()
    }


def _confusions(runs: Sequence[StepRun], groups: Sequence[Sequence[int]]) -> tuple[Confusion, ...]:
    if all(len(g) < 2 for g in groups):
        return (
            Confusion(
                ("run-to-run scatter", "noise"),
                1.0,
                "no slip level was repeated: scatter between runs is not in the standard errors",
                "repeat each slip level at another start angle",
            ),
        )
    if len({run.start for run in runs}) < 2:
        return (
            Confusion(
                ("steady_force", "once-per-turn error"),
                1.0,
                "one start angle only: an error that turns with the wheel looks the same in every "
                "run and cannot be told from the steady force",
                "repeat the slips at a start angle of 120 deg",
            ),
        )
    return ()
