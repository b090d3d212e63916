# SPDX-License-Identifier: Apache-2.0
"""Least squares of one record: several channels, coloured noise, an interval for every number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.identify.least_squares import Solution, solve
from flatplank_analysis.identify.noise import fit_noise
from flatplank_analysis.identify.results import Estimate, rmse

Model = Callable[[np.ndarray], Mapping[str, np.ndarray]]
"""sets of parameters (sets, p) -> channel -> output (sets, n)"""


@dataclass(frozen=True)
class FitParameter:
    """A parameter of a fit: start, bounds, and unit of the value."""

    name: str
    unit: str
    start: float
    lower: float
    upper: float


@dataclass(frozen=True)
class RecordFit:
    """Estimates by name; modelled values (n,) and root mean square error by channel."""

    estimates: Mapping[str, Estimate]
    modelled: Mapping[str, np.ndarray]
    rmse: Mapping[str, float]


def fit_record(
    model: Model, measured: Mapping[str, np.ndarray], unknowns: Sequence[FitParameter]
) -> RecordFit:
    """Fit `unknowns` to channels of shape (n,), each weighted by its own spread.

    The noise of a channel is autoregressive and estimated from the residual. Model errors count
    as noise, so that the intervals are wide where the model does not fit.
    """
    size = {name: max(float(np.std(y)), 1e-9) for name, y in measured.items()}

    def residuals(sets: np.ndarray) -> np.ndarray:
        out = model(sets)
        return np.hstack([(out[name] - y) / size[name] for name, y in measured.items()])

    start, lower, upper = np.array([(u.start, u.lower, u.upper) for u in unknowns]).T
    solution = solve(residuals, start, lower, upper, np.maximum(np.abs(start), 1e-6))
    count = len(next(iter(measured.values())))
    parts = {n: slice(i * count, (i + 1) * count) for i, n in enumerate(measured)}
    errors, dof = _errors(solution, parts)
    found = {n: measured[n] + size[n] * solution.residual[part] for n, part in parts.items()}
    return RecordFit(
        {u.name: _estimate(u, solution, k, errors[k], dof) for k, u in enumerate(unknowns)},
        found,
        {n: rmse(measured[n], found[n]) for n in measured},
    )


def _errors(solution: Solution, parts: Mapping[str, slice]) -> tuple[np.ndarray, float]:
    """Standard errors (p,) and degrees of freedom in coloured noise."""
    # columns of length one: the parameters have units from 1e-4 rad to 1e5 N/m
    length = np.linalg.norm(solution.jacobian, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    jac = solution.jacobian / length
    meat = np.zeros((jac.shape[1],) * 2)
    samples = 0.0
    for part in parts.values():
        noise = fit_noise([solution.residual[part]])
        meat += noise.score_covariance(jac[part])
        samples += noise.effective_samples
    inverse = np.linalg.pinv(jac.T @ jac)
    covariance = inverse @ meat @ inverse
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / length
    return size, max(samples - jac.shape[1], 2.0)


def _estimate(u: FitParameter, solution: Solution, k: int, error: float, dof: float) -> Estimate:
    """An estimate; it is not determined when it is at its bound or no column depends on it."""
    edge = "lower" if solution.at_lower[k] else "upper" if solution.at_upper[k] else ""
    seen = bool(np.any(solution.jacobian[:, k])) and not edge
    note = f"rests on its {edge} bound" if edge else "" if seen else "not determined"
    return Estimate(u.name, float(solution.x[k]), u.unit, float(error), dof, edge, seen, note=note)


def relaxed(values: np.ndarray, spacing: float, sigma: np.ndarray) -> np.ndarray:
    """u' of sigma du'/dx + u' = u on a uniform grid, exact for a piecewise linear input.

    values (n,), spacing [m], sigma (sets,) [m]; returns (sets, n), at rest at the first sample.
    """
    sigma = np.maximum(np.asarray(sigma, float), 1e-6)
    decay = np.exp(-spacing / sigma)
    mean = sigma / spacing * (1.0 - decay)
    out = np.empty((len(sigma), len(values)))
    out[:, 0] = values[0]
    for i in range(1, len(values)):
        before, now = values[i - 1], values[i]
        out[:, i] = now - mean * (now - before) + decay * (out[:, i - 1] - before)
    return out
