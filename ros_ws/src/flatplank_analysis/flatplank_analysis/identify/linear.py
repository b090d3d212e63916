# SPDX-License-Identifier: Apache-2.0
"""Linear transient model (7.9-7.11) of one run: relaxation length and slip stiffness of a step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..post.gridding import CELL, bin_means
from .least_squares import Solution, solve
from .noise import ARNoise, fit_noise
from .results import Confusion, Estimate, rmse, to_plain

BEFORE = 0.1
"""Travel before the step from which the start force is determined [m]."""
BEFORE_WEIGHT = 20.0
"""Weight of a squared error before the step: it makes the start force follow the measurement
there, instead of improving the fit of the response."""
SIGMA_BOUNDS = (0.005, 5.0)
"""Relaxation length [m]: from a small part of a contact length to more than the plank."""
STIFFNESS_LIMIT = 1e7
"""Largest absolute value of the local slip stiffness [N]; it is negative in y (ISO W)."""
SMALLEST_SLIP = 2e-3
"""Slip below which a run does not determine sigma and C [-]."""
SLOPE_LIMIT = 0.05
"""The transient part ends where slope over steady force falls below this [1/m]."""
TRANSIENT_WEIGHT = 100.0
"""Weight of a squared error in the transient part against 1 in the steady part (7.25)."""


@dataclass(frozen=True)
class LinearFit:
    """First-order response F = F0 + (C kappa - F0)(1 - exp(-s/sigma)) fitted to one run."""

    kappa: float
    sigma: Estimate
    """Relaxation length sigma_x [m]."""
    slip_stiffness: Estimate
    """Local slip stiffness C'_Fkappa [N]."""
    steady_force: Estimate
    """Asymptote C kappa [N], fitted together with sigma; the mean where kappa = 0."""
    start_force: Estimate
    """Force at the step [N]."""
    reached_force: float
    """Modelled force at the end of the record: the thesis's steady-state force [N]."""
    correlation: float
    """Correlation of the errors of sigma and asymptote [-]."""
    settled: bool
    """True when the record is long enough for 95 % of the change of force."""
    transient_end: float
    """Distance since the step at which the transient part ends [m]."""
    rmse_transient: float
    """Root-mean-square error in the transient part [N]; where kappa = 0, after the step."""
    rmse_total: float
    """Root-mean-square error after the step [N]."""
    confusions: tuple[Confusion, ...] = ()
    noise: ARNoise = field(default=ARNoise((), 0.0, 1), repr=False)
    distance: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False)
    """Distance since the step (n,) [m]."""
    residual: np.ndarray = field(default_factory=lambda: np.zeros(0), repr=False)
    """Measured minus modelled force at `distance` (n,) [N]."""

    def response(self, distance: np.ndarray) -> np.ndarray:
        """Modelled force [N] at distances since the step [m]."""
        x = np.asarray(distance, float)
        change = self.steady_force.value - self.start_force.value
        if not self.sigma.determined:
            return np.full_like(x, self.steady_force.value)
        return self.start_force.value + change * first_order_rise(x, self.sigma.value)

    def to_json(self) -> dict[str, Any]:
        """Numbers only; the arrays stay out."""
        names = (
            "kappa", "sigma", "slip_stiffness", "steady_force", "start_force", "reached_force",
            "correlation", "settled", "transient_end", "rmse_transient", "rmse_total",
            "confusions",
        )  # fmt: skip
        return {n: to_plain(getattr(self, n)) for n in names} | {
            n: getattr(self, n).to_json()
            for n in ("sigma", "slip_stiffness", "steady_force", "start_force")
        }


def first_order_rise(distance: np.ndarray, sigma: np.ndarray | float) -> np.ndarray:
    """1 - exp(-s/sigma) over the distance s since the step (7.11); 0 before it."""
    return -np.expm1(-np.maximum(distance, 0.0) / sigma)


def linear_run(
    distance: np.ndarray,
    fx: np.ndarray,
    kappa: float,
    *,
    noise: ARNoise | None = None,
    spacing: float = CELL,
) -> LinearFit:
    """Fit the linear transient model to one run.

    `distance` since the step [m] (the 0.1 m before it give the start force), `fx` the
    force [N], `kappa` the actual slip. Without samples before the step the start force is 0, as in
    the thesis. `noise`: from repeats (on the same spacing); otherwise from the residual.
    """
    keep = np.asarray(distance) >= -BEFORE
    x, force = bin_means(np.asarray(distance)[keep], np.asarray(fx)[keep], spacing)
    if abs(kappa) < SMALLEST_SLIP:
        return _mean_only(x, force, kappa, noise)
    return _fit(x, force, kappa, noise)


def _fit(x: np.ndarray, force: np.ndarray, kappa: float, noise: ARNoise | None) -> LinearFit:
    """Search over (sigma, asymptote, start force); the slip stiffness is asymptote / kappa."""
    top = STIFFNESS_LIMIT * abs(kappa)
    lower = np.array([SIGMA_BOUNDS[0], -top, -np.inf])
    upper = np.array([SIGMA_BOUNDS[1], top, np.inf])
    fixed = not np.any(x < 0.0)
    count = 2 if fixed else 3
    weight = np.where(x < 0.0, np.sqrt(BEFORE_WEIGHT), 1.0)

    def residuals(sets: np.ndarray) -> np.ndarray:
        rise = first_order_rise(x, sets[:, :1])
        first = 0.0 if fixed else sets[:, 2:3]
        return weight * (first + (sets[:, 1:2] - first) * rise - force)

    start = _start(x, force, fixed)
    scale = np.array([0.1, max(np.ptp(force), 1.0), max(np.ptp(force), 1.0)])[:count]
    solution = solve(residuals, start[:count], lower[:count], upper[:count], scale)
    noise = fit_noise([solution.residual / weight]) if noise is None else noise
    sigma, steady = solution.x[:2]
    first = 0.0 if fixed else float(solution.x[2])
    errors, correlation = _errors(solution, noise, weight)
    dof = max(noise.effective_samples - len(solution.x), 2.0)
    response = first + (steady - first) * first_order_rise(x, sigma)
    end = transient_end(x, response, steady)
    settled = bool(x[-1] > 3.0 * sigma)
    confusions = () if settled and abs(correlation) < 0.95 else (_unsettled(correlation, sigma),)

    def estimate(name: str, value: float, unit: str, error: float, edge: str) -> Estimate:
        """An estimate; one on its bound is no measurement and is marked as not determined."""
        note = f"rests on its {edge} bound" if edge else ""
        return Estimate(name, float(value), unit, error, dof, edge, not edge, note=note)

    edge = solution.edges
    local, spread = steady / kappa, errors[1] / abs(kappa)
    start_error = 0.0 if fixed else errors[2]
    return LinearFit(
        kappa=float(kappa),
        sigma=estimate("sigma", sigma, "m", errors[0], edge[0]),
        slip_stiffness=estimate("slip_stiffness", local, "N", spread, edge[1]),
        steady_force=estimate("steady_force", steady, "N", errors[1], edge[1]),
        start_force=Estimate("start_force", first, "N", start_error, dof, fixed=fixed),
        reached_force=float(response[-1]),
        correlation=correlation,
        settled=settled,
        transient_end=end,
        rmse_transient=rmse(force, response, is_transient(x, end)),
        rmse_total=rmse(force, response, x >= 0.0),
        confusions=confusions,
        noise=noise,
        distance=x,
        residual=force - response,
    )


def _start(x: np.ndarray, force: np.ndarray, fixed: bool) -> np.ndarray:
    """Sigma, asymptote and start force (3,): best of 15 sigmas, forces by linear least squares."""
    best, found = np.inf, np.zeros(3)
    for sigma in np.geomspace(0.02, 2.5, 15):
        rise = first_order_rise(x, sigma)
        columns = np.column_stack([rise, 1.0 - rise])[:, : 1 if fixed else 2]
        forces = np.linalg.lstsq(columns, force, rcond=None)[0]
        cost = float(np.sum((columns @ forces - force) ** 2))
        if cost < best:
            best, found = cost, np.array([sigma, *forces, 0.0])[:3]
    return found


def _errors(solution: Solution, noise: ARNoise, weight: np.ndarray) -> tuple[list[float], float]:
    """Standard errors of plain least squares in coloured noise, and corr(sigma, asymptote)."""
    jac = solution.jacobian
    inverse = np.linalg.pinv(jac.T @ jac)
    covariance = inverse @ noise.score_covariance(jac * weight[:, None]) @ inverse
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    product = size[0] * size[1]
    correlation = float(covariance[0, 1] / product) if product > 0 else 0.0
    return [float(s) for s in size], correlation


def _unsettled(correlation: float, sigma: float) -> Confusion:
    return Confusion(
        ("sigma", "slip_stiffness"),
        correlation,
        "the run ends before the force has settled: a longer relaxation length with a larger slip "
        "stiffness fits as well",
        f"step earlier, so that {3.0 * sigma:.2f} m of travel follow the step",
    )


def _mean_only(x: np.ndarray, force: np.ndarray, kappa: float, noise: ARNoise | None) -> LinearFit:
    """Without slip there is no response: the steady force is the mean after the step."""
    after = x >= 0.0
    mean = float(np.mean(force[after]))
    residual = force - mean
    noise = fit_noise([residual[after]]) if noise is None else noise
    ones = np.ones((np.count_nonzero(after), 1)) / np.count_nonzero(after)
    error = float(np.sqrt(noise.score_covariance(ones)[0, 0]))
    dof = max(noise.effective_samples - 1.0, 2.0)
    note = "not determined: this run has no slip"
    return LinearFit(
        kappa=float(kappa),
        sigma=Estimate("sigma", float("nan"), "m", determined=False, note=note),
        slip_stiffness=Estimate("slip_stiffness", float("nan"), "N", determined=False, note=note),
        steady_force=Estimate("steady_force", mean, "N", error, dof),
        start_force=Estimate("start_force", mean, "N", error, dof),
        reached_force=mean,
        correlation=0.0,
        settled=True,
        transient_end=float(x[-1]),
        rmse_transient=rmse(force, np.full_like(force, mean), after),
        rmse_total=rmse(force, np.full_like(force, mean), after),
        noise=noise,
        distance=x,
        residual=residual,
    )


def transient_end(distance: np.ndarray, response: np.ndarray, steady_force: float) -> float:
    """Distance since the step [m] at which the transient part of a fitted response ends.

    Section 7.1: the gradient over the steady force falls below 0.05, read here as per metre.
    Without a steady force (kappa = 0) everything after the step is the transient part.
    """
    after = distance >= 0.0
    x, f = distance[after], response[after]
    if len(x) < 3 or not np.isfinite(steady_force) or abs(steady_force) < 1e-9:
        return float(x[-1]) if len(x) else 0.0
    slope = np.abs(np.gradient(f, x)) / abs(steady_force)
    # search behind the steepest place, because a plateau at the beginning has no slope either
    first = int(np.argmax(slope))
    below = np.flatnonzero(slope[first:] < SLOPE_LIMIT)
    return float(x[first + below[0]]) if len(below) else float(x[-1])


def is_transient(distance: np.ndarray, end: float) -> np.ndarray:
    """Mask of the samples from the step to the end of the transient part."""
    return (distance >= 0.0) & (distance <= end)


def transient_weights(distance: np.ndarray, end: float) -> np.ndarray:
    """Weights of (7.25): 100 in the transient part, 1 in the steady part, 0 before the step."""
    weights = np.where(is_transient(distance, end), TRANSIENT_WEIGHT, 1.0)
    return np.where(distance >= 0.0, weights, 0.0)
