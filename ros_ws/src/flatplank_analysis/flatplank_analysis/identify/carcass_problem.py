# SPDX-License-Identifier: Apache-2.0
"""The carcass stiffness of one condition as a least-squares problem, and its solution.

First c_cx alone minimises the weighted error (7.25), (7.26), where the transient part dominates.
Then c_cx and the steady curve are solved for together: the steady force of a level is chosen so
that *this* model has no mean error in the settled part of its runs. The asymptote of a first-order
fit, and with it c_cx, would be biased where the response is not exponential. The equations also
give the contribution of each run to each result, and so the standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..models.base import TOYO, ContactGeometry, RunInputs, stack_runs
from ..models.nonlinear import NonlinearX
from ..starts import mean_over_starts
from .least_squares import Solution, solve
from .linear import LinearFit, transient_weights
from .noise import ARNoise, fit_noise, repeat_differences
from .repeats import shared_fits
from .runs import StepRun, by_level
from .steady_curve import SteadyCurve, curve_law, steady_curve

GROWTH = 1.06
"""Ratio of widths of neighbouring cells of the fit [-]; the first cell has the runs' spacing."""
LARGEST_CELL = ((0.8, 0.008), (np.inf, 0.02))
"""(distance since the step, largest cell width up to it) [m]; narrow where the patch relaxes."""
LATE = 0.7
"""Share of a run's travel after which the force counts as settled, whatever its slope [-]."""
START = 2e5
"""Start value of c_cx [N/m] (section 7.2)."""


@dataclass(frozen=True)
class CarcassProblem:
    """Data and weights of all runs of one condition, and the model of c_cx and steady curve."""

    inputs: RunInputs
    distance: np.ndarray
    """Cell centres (samples,) [m] after the step."""
    measured: np.ndarray
    """Mean force per cell (runs, samples) [N]."""
    weight: np.ndarray
    """Root of the sum of the weights (7.25) over the cell (runs, samples)."""
    settled: np.ndarray
    """Number of samples per cell where the force has settled, else 0 (runs, samples)."""
    level: np.ndarray
    """Slip level of each run, as an index into the curve (runs,)."""
    curve: SteadyCurve
    geometry: ContactGeometry
    friction: float
    tread_stiffness: float | None
    longitudinal: bool = True

    def simulate(self, stiffness: np.ndarray, forces: np.ndarray | None = None) -> np.ndarray:
        """Model force (sets, runs, samples) for c_cx (sets, 1) and curve forces (sets, k)."""
        law = curve_law(self.curve.kappa, self.curve.force if forces is None else forces)
        model = NonlinearX(
            lambda _: law,
            self.geometry,
            self.friction,
            self.tread_stiffness,
            longitudinal=self.longitudinal,
        )
        return model.simulate(stiffness, self.inputs)

    def residuals(self, stiffness: np.ndarray) -> np.ndarray:
        """Residuals of the search over c_cx alone: (sets, 1) -> (sets, runs * samples)."""
        force = self.simulate(stiffness)
        return (self.weight * (force - self.measured)).reshape(len(stiffness), -1)


def search_carcass(problem: CarcassProblem, bounds: tuple[float, float] = (2e4, 5e6)) -> Solution:
    """Minimise (7.26) over c_cx [N/m]."""
    low, high, start = (np.array([v]) for v in (*bounds, START))
    return solve(problem.residuals, start, low, high, start, 1e-7)


def carcass_problem(
    runs: Sequence[StepRun],
    fits: Sequence[LinearFit] | None = None,
    *,
    geometry: ContactGeometry = TOYO,
    friction: float | None = None,
    tread_stiffness: float | None = None,
    longitudinal: bool = True,
) -> CarcassProblem:
    """Data, weights (7.25) and steady curve of one condition, ready for the search.

    `friction` mu (None: largest steady force over load, as in section 7.2), `tread_stiffness` c_px
    [N/m2] (None: tied to the slip stiffness of the steady curve). `longitudinal`: False in y.
    """
    fits = shared_fits(runs) if fits is None else fits
    curve = steady_curve(runs, fits)
    if friction is None:
        load = mean_over_starts([run.mean_load for run in runs], [run.start for run in runs])
        friction = float(np.max(np.abs(curve.force)) / load)
    x, force, weight, settled = _measured(runs, fits)
    order = {value: i for i, value in enumerate(by_level(runs))}
    level = np.array([order[run.level] for run in runs])
    rows = [r.inputs_at(x, f.start_force.value) for r, f in zip(runs, fits, strict=True)]
    return CarcassProblem(
        stack_runs(rows),
        x,
        force,
        weight,
        settled,
        level,
        curve,
        geometry,
        friction,
        tread_stiffness,
        longitudinal,
    )


def _measured(
    runs: Sequence[StepRun], fits: Sequence[LinearFit]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cell centres (n,), mean force, root of the summed weights, settled samples (runs, n).

    Cells that a run does not fill have zero weight.
    """
    longest = max((run.after_step(run.distance) for run in runs), key=len)
    first = _cells(len(longest), float(longest[1] - longest[0]))
    centres = _cell_sums(longest, first) / np.diff(first)
    force, weight, settled = (np.zeros((len(runs), len(centres))) for _ in range(3))
    for i, (run, fit) in enumerate(zip(runs, fits, strict=True)):
        own = run.after_step(run.distance)
        full = int(np.searchsorted(first, len(own), side="right")) - 1
        edges = first[: full + 1]
        force[i, :full] = _cell_sums(run.after_step(run.fx), edges) / np.diff(edges)
        weights = transient_weights(own, fit.transient_end)
        weight[i, :full] = np.sqrt(_cell_sums(weights, edges))
        late = own >= min(fit.transient_end, LATE * own[-1])
        settled[i, :full] = _cell_sums(late.astype(float), edges)
    return centres, force, weight, settled


def _cells(samples: int, spacing: float) -> np.ndarray:
    """Index of the first sample of every cell, and of the end."""
    edges, width = [0.0], spacing
    while edges[-1] < samples * spacing:
        edges.append(edges[-1] + width)
        limit = next(size for end, size in LARGEST_CELL if edges[-1] < end)
        width = min(width * GROWTH, limit)
    index = np.unique(np.round(np.array(edges) / spacing).astype(int))
    return index[index <= samples]


def _cell_sums(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.add.reduceat(values[: edges[-1]], edges[:-1])


TURNS = 12
"""Largest number of Newton steps."""
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
    """Weights of the errors in each run's equations for c_cx and its level (2, runs, samples)."""
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

        The steady forces of the other levels are kept.
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
        """Derivative of a quantity with this gradient (1 + k,) by each error (runs, samples)."""
        part = -np.linalg.lstsq(self.matrix.T, gradient, rcond=None)[0]
        return part[0] * self.rows[0] + part[1 + self.problem.level][:, None] * self.rows[1]


def joint_state(problem: CarcassProblem, c_cx: float) -> JointState:
    """Simulate the model and its derivatives in one call of 2 + k parameter sets."""
    forces = problem.curve.force
    k = len(forces)
    step = np.concatenate([[1e-4 * c_cx], np.maximum(1e-4 * np.abs(forces), 0.5)])
    sets = np.tile(np.concatenate([[c_cx], forces]), (k + 2, 1))
    sets[1:] += np.diag(step)
    out = problem.simulate(sets[:, :1], sets[:, 1:])
    slopes = (out[1:] - out[0]) / step[:, None, None]
    own = slopes[1 + problem.level, np.arange(len(problem.level))]
    rows = np.array([problem.weight**2 * slopes[0], problem.settled * own])
    every = np.einsum("ern,prn->erp", rows, slopes)
    return JointState(problem, c_cx, out[0] - problem.measured, rows, every)


def solve_jointly(
    problem: CarcassProblem, c_cx: float, bounds: tuple[float, float]
) -> tuple[JointState, bool]:
    """Solve for c_cx and the steady curve together by Newton steps, starting from c_cx [N/m].

    Returns the state, and True when it has converged. The thesis keeps the first curve.
    """
    state = joint_state(problem, c_cx)
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
    """Noise from differences between repeats (otherwise residuals) on the runs' uniform grid."""
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
    """Standard error by the noise alone, for a quantity with this sensitivity."""
    cells = np.gradient(state.problem.distance)
    total = 0.0
    for run, row in zip(runs, sensitivity, strict=True):
        own = run.after_step(run.distance)
        density = np.interp(own, state.problem.distance, row / cells) * (own[1] - own[0])
        total += float(noise.score_covariance(density[:, None])[0, 0])
    return float(np.sqrt(total))
