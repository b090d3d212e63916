# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness per operating condition with the weights of (7.25), and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import FlatplankError
from ..models.base import RunInputs, TransientModel, stack_runs
from ..models.contact import TOYO, ContactGeometry
from ..models.nonlinear import NonlinearX
from ..models.steady_law import TableLaw, table_law
from .least_squares import Solution, solve
from .linear import LinearFit
from .noise import fit_noise, repeat_differences
from .quality import is_transient, transient_weights
from .results import Confusion, Estimate, to_plain
from .runs import StepRun, by_level

GROWTH = 1.06
"""Cells of the fit grow by this factor from the runs' own grid at the step ..."""
LARGEST_CELL = ((0.8, 0.008), (np.inf, 0.02))
"""... to this width [m] up to this distance [m]: the relaxation of the patch collapses early."""
START = 2e5
"""Start value of c_cx [N/m] (section 7.2)."""


@dataclass(frozen=True)
class SteadyCurve:
    """F_ss over kappa of one condition (figure 7.7) from the runs' linear fits."""

    kappa: np.ndarray
    """Mean actual slip per level (k,) [-]."""
    force: np.ndarray
    """Mean asymptote per level (k,) [N]."""
    influence: np.ndarray = field(repr=False)
    """What each run brings to each level's mean (runs, k) [N]; its square sum is the variance."""
    repeats: np.ndarray = field(repr=False)
    """Number of runs per level (k,)."""

    def law(self) -> TableLaw:
        """As the look-up table of the model."""
        return table_law(self.kappa, self.force)

    @property
    def std_error(self) -> np.ndarray:
        """Standard error of each level from its repeats (k,) [N]; NaN for a single run."""
        n = self.repeats
        spread = np.sqrt(np.sum(self.influence**2, axis=0) * n / np.maximum(n - 1, 1))
        return np.where(n > 1, spread, np.nan)


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


def steady_curve(runs: Sequence[StepRun], fits: Sequence[LinearFit]) -> SteadyCurve:
    """Mean asymptote per slip level; repeats are averaged."""
    levels = by_level(runs)
    place = {id(run): i for i, run in enumerate(runs)}
    influence = np.zeros((len(runs), len(levels)))
    kappa, force, repeats = [], [], []
    for column, members in enumerate(levels.values()):
        index = [place[id(m)] for m in members]
        asymptotes = np.array([fits[i].steady_force.value for i in index])
        kappa.append(np.mean([m.kappa for m in members]))
        force.append(asymptotes.mean())
        repeats.append(len(members))
        influence[index, column] = (asymptotes - asymptotes.mean()) / len(members)
    return SteadyCurve(np.array(kappa), np.array(force), influence, np.array(repeats))


@dataclass(frozen=True)
class CarcassProblem:
    """Weighted residuals of all runs of one condition over (c_cx) and the curve's forces."""

    inputs: RunInputs
    distance: np.ndarray
    """Cell centres (samples,) [m] after the step."""
    measured: np.ndarray
    weight: np.ndarray
    curve: SteadyCurve
    geometry: ContactGeometry
    friction: float
    tread_stiffness: float | None

    def simulate(self, lanes: np.ndarray) -> np.ndarray:
        """Model force (lanes, runs, samples); lanes (lanes, 1 + k) of c_cx and curve forces."""
        law = table_law(self.curve.kappa, lanes[:, 1:] if len(lanes) > 1 else lanes[0, 1:])
        return self.model(law).simulate(lanes[:, :1], self.inputs)

    def model(self, law: TableLaw) -> TransientModel:
        """The model with this steady law."""
        return NonlinearX(lambda _: law, self.geometry, self.friction, self.tread_stiffness)

    def residuals(self, stiffness: np.ndarray) -> np.ndarray:
        """For the search over c_cx alone: (lanes, 1) -> (lanes, runs * samples)."""
        force = self.model(self.curve.law()).simulate(stiffness, self.inputs)
        return (self.weight * (force - self.measured)).reshape(len(stiffness), -1)


def fit_carcass(
    runs: Sequence[StepRun],
    *,
    geometry: ContactGeometry = TOYO,
    friction: float | None = None,
    tread_stiffness: float | None = None,
    bounds: tuple[float, float] = (2e4, 5e6),
) -> CarcassFit:
    """Identify c_cx [N/m] from all runs of one condition (7.25), (7.26).

    `friction` mu (None: largest steady force over load, as in section 7.2), `tread_stiffness` c_px
    [N/m2] (None: tied to the slip stiffness of the steady curve).
    """
    if len({r.condition for r in runs}) != 1 or len({r.level for r in runs}) < 3:
        raise FlatplankError(
            "the carcass stiffness needs three or more slip levels of one condition",
            str(runs[0].condition) if runs else "",
            "add slip levels",
        )
    fits = [run.linear() for run in runs]
    problem = carcass_problem(
        runs,
        fits,
        geometry=geometry,
        friction=friction,
        tread_stiffness=tread_stiffness,
    )
    solution = search_carcass(problem, bounds)
    return _report(runs, fits, problem, solution)


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
) -> CarcassProblem:
    """Data, weights (7.25) and steady curve of one condition, ready for the search."""
    fits = [run.linear() for run in runs] if fits is None else fits
    curve = steady_curve(runs, fits)
    if friction is None:
        load = np.mean([run.mean_load for run in runs])
        friction = float(np.max(np.abs(curve.force)) / load)
    x, force, weight = _measured(runs, fits)
    rows = [r.inputs_at(x, f.start_force.value) for r, f in zip(runs, fits, strict=True)]
    return CarcassProblem(
        stack_runs(rows), x, force, weight, curve, geometry, friction, tread_stiffness
    )


def _measured(
    runs: Sequence[StepRun], fits: Sequence[LinearFit]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell centres (n,), mean force and root of the summed weights (runs, n).

    Cells that a run does not fill have no weight in it.
    """
    longest = max((run.after_step(run.distance) for run in runs), key=len)
    first = _cells(len(longest), float(longest[1] - longest[0]))
    centres = _cell_sums(longest, first) / np.diff(first)
    force, weight = np.zeros((len(runs), len(centres))), np.zeros((len(runs), len(centres)))
    for i, (run, fit) in enumerate(zip(runs, fits, strict=True)):
        own = run.after_step(run.distance)
        full = int(np.searchsorted(first, len(own), side="right")) - 1
        edges = first[: full + 1]
        force[i, :full] = _cell_sums(run.after_step(run.fx), edges) / np.diff(edges)
        weights = transient_weights(own, fit.transient_end)
        weight[i, :full] = np.sqrt(_cell_sums(weights, edges))
    return centres, force, weight


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


def _report(
    runs: Sequence[StepRun], fits: Sequence[LinearFit], problem: CarcassProblem, solution: Solution
) -> CarcassFit:
    c_cx, curve = float(solution.x[0]), problem.curve
    influence, noise_error = _influences(runs, problem, solution)
    dof = _degrees_of_freedom(curve, problem, solution)
    stiffness, stiffness_influence = _slope_at_zero(curve)
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
    """What each run brings to c_cx (runs,), its share in the steady curve included; noise alone."""
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


def _slope_at_zero(curve: SteadyCurve) -> tuple[float, np.ndarray]:
    """C_Fkappa [N] from the levels next to zero on both sides, and each run's part in it."""
    low = np.flatnonzero(curve.kappa < -2e-3)
    high = np.flatnonzero(curve.kappa > 2e-3)
    i = low[-1] if len(low) else 0
    j = high[0] if len(high) else len(curve.kappa) - 1
    span = curve.kappa[j] - curve.kappa[i]
    slope = (curve.force[j] - curve.force[i]) / span
    return float(slope), (curve.influence[:, j] - curve.influence[:, i]) / span


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
                "one start angle only: scatter between runs and an error that turns with the wheel "
                "cannot be told from the tire's response",
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
