# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness and steady curve together: two kinds of equations, one solution.

c_cx minimises the weighted error (7.25), which the transient part dominates. The steady force of
a level is what leaves no mean error in the settled part of its runs under *this* model: the
asymptote of a first-order fit is biased where the response is not exponential, and c_cx with it.
Solving both at once also gives what each run brings to each result, and so their standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .carcass_problem import CarcassProblem
from .noise import ARNoise, fit_noise, repeat_differences
from .runs import StepRun

TURNS = 12
SMALL = 1e-6
"""Relative change of c_cx at which the iteration ends."""


@dataclass(frozen=True)
class JointState:
    """Model and its derivatives at one c_cx and steady curve."""

    problem: CarcassProblem
    c_cx: float
    error: np.ndarray
    """Modelled minus measured force (runs, samples) [N]."""
    rows: np.ndarray
    """Weights of the errors in each run's equations (2, runs, samples): c_cx, its own level."""
    every: np.ndarray
    """Derivative of each run's two equations by (c_cx, forces) (2, runs, 1 + k)."""

    @property
    def matrix(self) -> np.ndarray:
        """Derivative of the summed equations by (c_cx, forces) (1 + k, 1 + k)."""
        return self._summed(self.every)

    def scores(self) -> np.ndarray:
        """Left-hand sides of the equations (1 + k,); zero at the solution."""
        return self._summed(np.sum(self.rows * self.error, axis=2)[:, :, None])[:, 0]

    def stiffness_of(self, part: np.ndarray) -> float:
        """c_cx [N/m] of some of the runs alone, to first order; part (runs,) bool.

        The steady forces of the other levels stay as they are.
        """
        own = np.sum(self.rows * self.error, axis=2)[:, :, None]
        matrix, scores = (self._summed(values * part[:, None]) for values in (self.every, own))
        free = np.append(0, 1 + self.problem.level[part])
        change = np.linalg.lstsq(matrix[np.ix_(free, free)], scores[free, 0], rcond=None)[0]
        return self.c_cx - float(change[0])

    def _summed(self, values: np.ndarray) -> np.ndarray:
        """Equations of every run (2, runs, n) as those of c_cx and of the levels (1 + k, n)."""
        out = np.zeros((self.every.shape[2], values.shape[2]))
        out[0] = values[0].sum(axis=0)
        np.add.at(out, 1 + self.problem.level, values[1])
        return out

    def sensitivity(self, gradient: np.ndarray) -> np.ndarray:
        """How a quantity with this gradient (1 + k,) follows each error (runs, samples)."""
        part = -np.linalg.lstsq(self.matrix.T, gradient, rcond=None)[0]
        return part[0] * self.rows[0] + part[1 + self.problem.level][:, None] * self.rows[1]


def joint_state(problem: CarcassProblem, c_cx: float) -> JointState:
    """Simulate the model and its derivatives in one call of 2 + k lanes."""
    forces = problem.curve.force
    k = len(forces)
    step = np.concatenate([[1e-4 * c_cx], np.maximum(1e-4 * np.abs(forces), 0.5)])
    lanes = np.tile(np.concatenate([[c_cx], forces]), (k + 2, 1))
    lanes[1:] += np.diag(step)
    out = problem.simulate(lanes)
    slopes = (out[1:] - out[0]) / step[:, None, None]
    own = slopes[1 + problem.level, np.arange(len(problem.level))]
    rows = np.array([problem.weight**2 * slopes[0], problem.settled * own])
    every = np.einsum("ern,prn->erp", rows, slopes)
    return JointState(problem, c_cx, out[0] - problem.measured, rows, every)


def solve_jointly(
    problem: CarcassProblem, c_cx: float, bounds: tuple[float, float], refine: bool = True
) -> tuple[JointState, bool]:
    """Newton steps on both kinds of equations from the solution with the first curve.

    Without `refine` the curve stays as it is (the thesis's way). Returns state and convergence.
    """
    state = joint_state(problem, c_cx)
    if not refine:
        return state, True
    for _ in range(TURNS):
        change = -np.linalg.lstsq(state.matrix, state.scores(), rcond=None)[0]
        ahead = float(np.clip(state.c_cx + np.clip(change[0], -0.3 * c_cx, 0.3 * c_cx), *bounds))
        curve = replace(problem.curve, force=problem.curve.force + change[1:])
        problem = replace(problem, curve=curve)
        moved = abs(ahead - state.c_cx)
        state = joint_state(problem, ahead)
        if moved <= SMALL * ahead:
            return state, True
    return state, False


def repeat_noise(runs: Sequence[StepRun], state: JointState) -> ARNoise:
    """Noise from differences between repeats (else residuals) on the runs' own even grid."""
    problem = state.problem
    modelled = problem.measured + state.error
    groups: dict[float, list[np.ndarray]] = {}
    length = min(len(run.after_step(run.distance)) for run in runs)
    for run, row in zip(runs, modelled, strict=True):
        own = run.after_step(run.distance)[:length]
        error = run.after_step(run.fx)[:length] - np.interp(own, problem.distance, row)
        groups.setdefault(run.level, []).append(error)
    every = [error for group in groups.values() for error in group]
    return fit_noise(repeat_differences([np.array(g) for g in groups.values()]) or every)


def noise_error(
    runs: Sequence[StepRun], state: JointState, sensitivity: np.ndarray, noise: ARNoise
) -> float:
    """Standard error that the noise alone gives a quantity with this sensitivity."""
    cells = np.gradient(state.problem.distance)
    total = 0.0
    for run, row in zip(runs, sensitivity, strict=True):
        own = run.after_step(run.distance)
        density = np.interp(own, state.problem.distance, row / cells) * (own[1] - own[0])
        total += float(noise.score_covariance(density[:, None])[0, 0])
    return float(np.sqrt(total))
