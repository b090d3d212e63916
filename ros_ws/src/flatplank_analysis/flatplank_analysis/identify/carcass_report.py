# SPDX-License-Identifier: Apache-2.0
"""What the carcass fit says and how sure it is: noise, scatter, and the steady curve's share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .carcass_problem import CarcassProblem
from .least_squares import Solution
from .linear import LinearFit
from .noise import fit_noise, repeat_differences
from .quality import is_transient
from .results import Confusion, Estimate, to_plain
from .runs import StepRun
from .steady_curve import SteadyCurve, slope_at_zero


@dataclass(frozen=True)
class CarcassFit:
    """Result of the nonlinear model for one condition."""

    condition: Any
    c_cx: Estimate
    slip_stiffness: Estimate
    """C_Fkappa: slope of the steady curve at zero slip [N]."""
    sigma_x: Estimate
    """Relaxation length (7.27) [m]."""
    half_length: float
    """a at the mean load [m]."""
    curve: SteadyCurve
    rmse: dict[float, float]
    """Per nominal slip: root-mean-square error in the transient part [N]."""
    runs: int
    confusions: tuple[Confusion, ...] = ()
    converged: bool = True
    evaluations: int = 0

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "condition": str(self.condition),
            "c_cx": self.c_cx.to_json(),
            "slip_stiffness": self.slip_stiffness.to_json(),
            "sigma_x": self.sigma_x.to_json(),
            "half_length": self.half_length,
            "curve": {
                "kappa": to_plain(self.curve.kappa),
                "force": to_plain(self.curve.force),
                "std_error": to_plain(self.curve.std_error),
            },
            "rmse": {f"{k:g}": to_plain(v) for k, v in self.rmse.items()},
            "runs": self.runs,
            "confusions": [c.to_json() for c in self.confusions],
            "converged": self.converged,
        }


def report(
    runs: Sequence[StepRun], fits: Sequence[LinearFit], problem: CarcassProblem, solution: Solution
) -> CarcassFit:
    c_cx, curve = float(solution.x[0]), problem.curve
    influence, noise_error = _influences(runs, problem, solution)
    dof = _degrees_of_freedom(curve, problem, solution)
    stiffness, stiffness_influence = slope_at_zero(curve)
    a = float(problem.geometry.half_length(np.mean([r.mean_load for r in runs]), runs[0].pressure))
    sigma_influence = stiffness_influence / c_cx - stiffness / c_cx**2 * influence
    correction = _repeat_correction(curve)
    errors = [
        float(np.sqrt(np.sum(i**2) * correction))
        for i in (influence, stiffness_influence, sigma_influence)
    ]
    edge = "lower" if solution.at_lower[0] else "upper" if solution.at_upper[0] else ""
    error = max(errors[0], noise_error)
    modelled = problem.measured + (
        solution.residual.reshape(problem.measured.shape)
        / np.where(problem.weight > 0, problem.weight, 1.0)
    )
    return CarcassFit(
        condition=runs[0].condition,
        c_cx=Estimate("c_cx", c_cx, "N/m", error, dof, edge, determined=not edge),
        slip_stiffness=Estimate("slip_stiffness", stiffness, "N", errors[1], dof),
        sigma_x=Estimate(
            "sigma_x",
            stiffness / c_cx + a,
            "m",
            float(
                np.hypot(
                    errors[2], max(error**2 - errors[0] ** 2, 0.0) ** 0.5 * stiffness / c_cx**2
                )
            ),
            dof,
            determined=not edge,
        ),
        half_length=a,
        curve=curve,
        rmse=_rmse_per_level(runs, fits, problem, modelled),
        runs=len(runs),
        confusions=_confusions(runs, curve, edge),
        converged=solution.converged,
        evaluations=solution.iterations,
    )


def _influences(
    runs: Sequence[StepRun], problem: CarcassProblem, solution: Solution
) -> tuple[np.ndarray, float]:
    """What each run brings to c_cx (runs,), by the steady curve too; and the noise alone."""
    c, curve = solution.x[0], problem.curve
    k = len(curve.force)
    step = np.maximum(np.abs(curve.force) * 1e-4, 0.1)
    lanes = np.tile(np.concatenate([[c], curve.force]), (k + 1, 1))
    lanes[1:, 1:] += np.diag(step)
    out = problem.simulate(lanes) * problem.weight
    by_force = (out[1:] - out[0]) / step[:, None, None]
    jac = solution.jacobian[:, 0].reshape(problem.measured.shape)
    residual = solution.residual.reshape(problem.measured.shape)
    information = np.sum(jac**2)
    if not information > 0.0:
        return np.zeros(len(runs)), 0.0
    own = np.sum(jac * residual, axis=1)
    cross = np.einsum("rn,krn->k", jac, by_force)
    influence = -(own + curve.influence @ cross) / information
    return influence, _noise_error(runs, problem, jac, residual) / information


def _noise_error(
    runs: Sequence[StepRun], problem: CarcassProblem, jac: np.ndarray, residual: np.ndarray
) -> float:
    """Root of J' Omega J for noise fitted to differences between repeats (else to residuals).

    On the runs' own even grid, where a noise model has a meaning.
    """
    weight = np.where(problem.weight > 0.0, problem.weight, 1.0)
    grids = [run.after_step(run.distance) for run in runs]
    length = min(len(x) for x in grids)
    modelled = problem.measured + residual / weight
    groups: dict[float, list[np.ndarray]] = {}
    for run, x, row in zip(runs, grids, modelled, strict=True):
        error = run.after_step(run.fx) - np.interp(x, problem.distance, row)
        groups.setdefault(run.level, []).append(error[:length])
    every = [error for group in groups.values() for error in group]
    noise = fit_noise(repeat_differences([np.array(g) for g in groups.values()]) or every)
    total = 0.0
    for x, row, w in zip(grids, jac, problem.weight, strict=True):
        per_cell = np.gradient(problem.distance) / (x[1] - x[0])
        density = np.interp(x, problem.distance, row * w / per_cell)
        total += float(noise.score_covariance(density[:, None])[0, 0])
    return float(np.sqrt(total))


def _repeat_correction(curve: SteadyCurve) -> float:
    """Small-sample factor: a mean of n repeats hides 1/n of their scatter."""
    n = float(np.mean(curve.repeats))
    return n / (n - 1.0) if n > 1.0 else 1.0


def _degrees_of_freedom(curve: SteadyCurve, problem: CarcassProblem, solution: Solution) -> float:
    """Independent differences that the scatter rests on, weighted by what each run says."""
    jac = solution.jacobian[:, 0].reshape(problem.measured.shape)
    share = np.sum(jac**2, axis=1)
    if not np.sum(share) > 0.0:
        return 1.0
    effective = np.sum(share) ** 2 / np.sum(share**2)
    return float(max(effective / _repeat_correction(curve), 2.0))


def _rmse_per_level(
    runs: Sequence[StepRun],
    fits: Sequence[LinearFit],
    problem: CarcassProblem,
    modelled: np.ndarray,
) -> dict[float, float]:
    """Error per nominal slip in the transient part (Table 7.3), quadratic mean over repeats."""
    squares: dict[float, list[float]] = {}
    x = problem.distance
    for i, (run, fit) in enumerate(zip(runs, fits, strict=True)):
        part = is_transient(x, fit.transient_end)
        samples = problem.weight[i, part] ** 2
        error = (problem.measured[i, part] - modelled[i, part]) ** 2
        squares.setdefault(run.level, []).append(float(samples @ error / np.sum(samples)))
    return {level: float(np.sqrt(np.mean(v))) for level, v in sorted(squares.items())}


def _confusions(runs: Sequence[StepRun], curve: SteadyCurve, edge: str) -> tuple[Confusion, ...]:
    found = []
    if len({run.start for run in runs}) < 2:
        found.append(
            Confusion(
                ("run-to-run scatter", "once-per-turn error"),
                1.0,
                "one start angle only: scatter between runs and an error that turns with the "
                "wheel cannot be told from the tire's response",
                "repeat the slips at a start angle of 120 deg",
            )
        )
    elif np.all(curve.repeats < 2):
        found.append(
            Confusion(
                ("run-to-run scatter", "noise"),
                1.0,
                "no slip level was repeated: scatter between runs is not in the standard errors",
                "repeat each slip level at another start angle",
            )
        )
    if edge:
        found.append(
            Confusion(
                ("c_cx", "tread stiffness"),
                1.0,
                f"c_cx rests on its {edge} bound: the response does not show the carcass",
                "add steps of 2 to 5 % slip, which load the carcass most",
            )
        )
    return tuple(found)
