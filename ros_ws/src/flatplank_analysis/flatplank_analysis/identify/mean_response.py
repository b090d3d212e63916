# SPDX-License-Identifier: Apache-2.0
"""The mean of repeats from several start angles (section 6.2).

What turns with the wheel cancels in it, while a single run of small slip may follow such an error
to an absurd relaxation length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .linear import BEFORE, BEFORE_WEIGHT, LinearFit, linear_run
from .runs import StepRun, by_level


@dataclass(frozen=True)
class MeanResponse:
    """Linear model of the mean of some repeats."""

    fit: LinearFit
    std_error: np.ndarray
    """Of sigma [m], asymptote and start force [N], from the scatter of the runs (3,)."""


def balanced(runs: Sequence[StepRun]) -> list[StepRun]:
    """Runs in which every start angle of a level counts once.

    Where a level has several start angles with different numbers of runs, those of one angle are
    averaged: the mean of the angles would else follow the angle that was repeated most.
    """
    out: list[StepRun] = []
    for members in by_level(runs).values():
        starts: dict[int, list[StepRun]] = {}
        for run in members:
            starts.setdefault(run.start, []).append(run)
        uneven = len({len(same) for same in starts.values()}) > 1
        out += [_averaged(same) for same in starts.values()] if uneven else members
    return out if len(out) < len(runs) else list(runs)


def _averaged(runs: Sequence[StepRun]) -> StepRun:
    if len(runs) == 1:
        return runs[0]
    first = max(float(run.distance[0]) for run in runs)
    last = min(float(run.distance[-1]) for run in runs)
    x = runs[0].distance[(runs[0].distance >= first) & (runs[0].distance <= last)]
    columns = {
        name: np.mean([np.interp(x, run.distance, getattr(run, name)) for run in runs], axis=0)
        for name in ("fx", "fy", "mz", "fz", "slip")
    }
    kappa = float(np.mean([run.kappa for run in runs]))
    return replace(runs[0], distance=x, kappa=kappa, **columns)


def has_mean(runs: Sequence[StepRun], output: str = "fx") -> bool:
    """Whether these repeats started at different angles and have a slip to respond to."""
    slips = [run.kappa if output == "fx" else run.alpha for run in runs]
    return len({run.start for run in runs}) > 1 and min(np.abs(slips)) > 2e-3


def mean_response(runs: Sequence[StepRun], output: str = "fx") -> MeanResponse:
    """Fit (7.11) to the mean of repeats; its error is what the single runs pull (linearised)."""
    runs = balanced(runs)
    x, force = _stacked(runs, output)
    slips = [run.kappa if output == "fx" else run.alpha for run in runs]
    fit = linear_run(x, force.mean(axis=0), float(np.mean(slips)))
    weight = np.where(x < 0.0, np.sqrt(BEFORE_WEIGHT), 1.0)
    pulls = (weight * (force - fit.response(x))) @ np.linalg.pinv(_jacobian(fit, x, weight)).T
    count = len(runs)
    spread = pulls - pulls.mean(axis=0)
    return MeanResponse(fit, np.sqrt(np.sum(spread**2, axis=0) / (count * (count - 1.0))))


def shared_fits(runs: Sequence[StepRun], output: str = "fx") -> list[LinearFit]:
    """Fit of every run; repeats share the relaxation length of their mean, where there is one."""
    found: dict[int, LinearFit] = {}
    for members in by_level(runs).values():
        mean = mean_response(members, output).fit if has_mean(members, output) else None
        for run in members:
            found[id(run)] = run.linear(output) if mean is None else _own(run, output, mean)
    return [found[id(run)] for run in runs]


def asymptotes(runs: Sequence[StepRun], output: str = "fx") -> np.ndarray:
    """Steady force of every run [N], with the relaxation length that its repeats share (n,)."""
    return np.array([fit.steady_force.value for fit in shared_fits(runs, output)])


def _own(run: StepRun, output: str, mean: LinearFit) -> LinearFit:
    """The mean's fit with this run's own forces."""
    x = run.distance
    keep = x >= -BEFORE
    grown = -np.expm1(-np.maximum(x[keep], 0.0) / mean.sigma.value)
    weight = np.where(x[keep] < 0.0, np.sqrt(BEFORE_WEIGHT), 1.0)
    basis = weight[:, None] * np.column_stack([grown, 1.0 - grown])
    measured = weight * getattr(run, output)[keep]
    first = mean.start_force.value
    if mean.start_force.fixed:
        steady = np.linalg.lstsq(basis[:, :1], measured - first * basis[:, 1], rcond=None)[0][0]
    else:
        steady, first = np.linalg.lstsq(basis, measured, rcond=None)[0]
    return replace(
        mean,
        steady_force=replace(mean.steady_force, value=float(steady)),
        start_force=replace(mean.start_force, value=float(first)),
    )


def _stacked(runs: Sequence[StepRun], output: str) -> tuple[np.ndarray, np.ndarray]:
    """Distance (n,) that all runs share, and their forces on it (runs, n)."""
    first = max(float(run.distance[0]) for run in runs)
    last = min(float(run.distance[-1]) for run in runs)
    x = runs[0].distance
    x = x[(x >= max(first, -BEFORE)) & (x <= last)]
    return x, np.array([np.interp(x, run.distance, getattr(run, output)) for run in runs])


def _jacobian(fit: LinearFit, x: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Of the response by sigma, asymptote and start force, weighted (n, 3)."""
    sigma, change = fit.sigma.value, fit.steady_force.value - fit.start_force.value
    s = np.maximum(x, 0.0) / sigma
    rest = np.exp(-s)
    return weight[:, None] * np.column_stack([-change * s * rest / sigma, 1.0 - rest, rest])
