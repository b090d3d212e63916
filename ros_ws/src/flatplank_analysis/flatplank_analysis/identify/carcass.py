# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness of an operating point with the weights of (7.25), and its uncertainty by
noise, scatter between runs, and the form of the steady curve.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError

from ..starts import mean_over_starts
from .carcass_problem import (
    CarcassProblem,
    JointState,
    carcass_problem,
    noise_error,
    repeat_noise,
    search_carcass,
    solve_jointly,
)
from .linear import LinearFit, is_transient
from .noise import ARNoise
from .repeats import NOT_REPEATED, shared_fits, with_equal_starts
from .results import Confusion, Estimate, plain_condition, to_plain
from .runs import StepRun
from .steady_curve import SteadyCurve, slope_lack


def fit_carcass(
    runs: Sequence[StepRun], bounds: tuple[float, float] = (2e4, 5e6), **options: Any
) -> CarcassFit:
    """Identify c_cx [N/m] from all runs of one condition (7.25), (7.26).

    `options` as for `carcass_problem`: geometry, friction, tread_stiffness, longitudinal. Raises
    FlatplankError unless the runs have one condition and three or more slip levels.
    """
    if len({r.operating_point for r in runs}) != 1 or len({r.level for r in runs}) < 3:
        what = "the carcass stiffness needs three or more slip levels of one condition"
        raise FlatplankError(what, runs[0].operating_point_text if runs else "", "add slip levels")
    runs = with_equal_starts(runs)
    fits = shared_fits(runs)
    problem = carcass_problem(runs, fits, **options)
    solution = search_carcass(problem, bounds)
    state, done = solve_jointly(problem, float(solution.x[0]), bounds)
    low, high = (abs(state.c_cx - b) <= 1e-6 * b for b in bounds)
    edge = "lower" if low else "upper" if high else ""
    return report(runs, fits, state, edge, done and solution.converged)


class MeanOperatingPoint(NamedTuple):
    """Means over the runs of a fit; SI."""

    fz: float
    pressure: float
    alpha: float
    gamma: float

    @classmethod
    def of(cls, runs: Sequence[StepRun]) -> MeanOperatingPoint:
        """Means over the start angles."""
        values = [(r.mean_load, r.pressure, r.alpha, r.gamma) for r in runs]
        return cls(*map(float, mean_over_starts(values, [r.start for r in runs])))


@dataclass(frozen=True)
class CarcassFit:
    """Result of the nonlinear model for one condition."""

    operating_point: Any
    c_cx: Estimate
    slip_stiffness: Estimate
    """C_Fkappa: slope of the steady curve at zero slip [N]."""
    sigma_x: Estimate
    """Relaxation length (7.27) [m]."""
    model_bias: dict[str, float]
    """Relative bias of the model in c_cx and sigma_x for a tread of bristles (`brush_bias`)."""
    half_length: float
    """Half contact length a at the mean load [m]."""
    curve: SteadyCurve
    rmse: dict[float, float]
    """Per nominal slip: root-mean-square error in the transient part [N]."""
    runs: int
    at: MeanOperatingPoint
    confusions: tuple[Confusion, ...] = ()
    converged: bool = True
    beside: tuple[Estimate, ...] = ()
    """Further estimates of the same fit: in y steering zero and ply steer."""

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Carcass stiffness, slip stiffness, relaxation length; in y under their lateral names."""
        return (self.c_cx, self.slip_stiffness, self.sigma_x, *self.beside)

    @property
    def rolling_stiffness(self) -> float:
        """C_x = C_Fk / sigma_x (7.7) of the rolling tire [N/m]; NaN when not determined."""
        known = self.sigma_x.determined and self.slip_stiffness.determined
        return self.slip_stiffness.value / self.sigma_x.value if known else math.nan

    def without_bias(self) -> dict[str, Estimate]:
        """c_cx and sigma_x without the model's own bias, with the names of `model_bias`."""
        pairs = zip(self.model_bias.items(), (self.c_cx, self.sigma_x), strict=True)
        return {name: e.times(1.0 / (1.0 + bias)) for (name, bias), e in pairs}

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        free = self.without_bias()
        return {
            "condition": plain_condition(self.operating_point),
            **{e.name: e.to_json() for e in self.estimates},
            "model_bias": to_plain(self.model_bias),
            "without_bias": to_plain({k: e.value for k, e in free.items()}),
            "without_bias_interval90": to_plain({k: list(e.interval()) for k, e in free.items()}),
            "half_length": self.half_length,
            "curve": {
                "kappa": to_plain(self.curve.kappa),
                "force": to_plain(self.curve.force),
                "std_error": to_plain(self.curve.std_error),
            },
            "rmse": {f"{k:g}": to_plain(v) for k, v in self.rmse.items()},
            "runs": self.runs,
            "confusions": [c.to_json() for c in self.confusions],
            "converged": bool(self.converged),
        }


def report(
    runs: Sequence[StepRun], fits: Sequence[LinearFit], state: JointState, edge: str, done: bool
) -> CarcassFit:
    """Estimates of c_cx, C_Fk and sigma_x with their errors; `edge` names a bound c_cx is on."""
    problem, c_cx = state.problem, state.c_cx
    found = problem.curve.slope()
    slope, stiffness = found.weights, found.value
    at = MeanOperatingPoint.of(runs)
    a = float(problem.geometry.half_length(at.fz, runs[0].pressure))
    bias = brush_bias(c_cx, stiffness, a)
    noise = repeat_noise(runs, state)
    lack = slope_lack(problem.curve.kappa, problem.curve.force)
    note = f"not determined: needs {lack}" if lack else ""

    def estimate(
        name: str, value: float, unit: str, gradient: np.ndarray, form: float, held: str = edge
    ) -> Estimate:
        error, dof = _error(gradient, runs, state, noise)
        at_bound, known = edge if name == "c_cx" else "", not held and not lack
        error = math.hypot(error, form)
        return Estimate(name, value, unit, error, dof, at_bound, known, note=note)

    by_c_cx = np.append(1.0, np.zeros_like(slope))
    spread = form_error(state, bias["c_cx"], _error(by_c_cx, runs, state, noise)[0])
    form = math.hypot(found.form, stiffness * spread / c_cx) / c_cx
    gradient = np.append(-stiffness / c_cx**2, slope / c_cx)
    return CarcassFit(
        operating_point=runs[0].operating_point,
        c_cx=estimate("c_cx", c_cx, "N/m", by_c_cx, spread),
        slip_stiffness=estimate(
            "slip_stiffness", stiffness, "N", np.append(0.0, slope), found.form, held=""
        ),
        sigma_x=estimate("sigma_x", stiffness / c_cx + a, "m", gradient, form),
        model_bias=bias,
        half_length=a,
        curve=replace(problem.curve, std_error=_curve_errors(state)),
        rmse=_rmse_per_level(runs, fits, problem, problem.measured + state.error),
        runs=len(runs),
        at=at,
        confusions=_confusions(runs, problem.curve, lack, edge),
        converged=done,
    )


def brush_bias(c_cx: float, stiffness: float, a: float) -> dict[str, float]:
    """Relative bias of the model on a tread of bristles, in the limit of small slip.

    After a small step such a tread lags by 2a/3 on average (a parabola over 2a), the model by
    sigma_c = a. The carcass absorbs the difference, 1/c_cx = 1/c - a/(3 C_Fk), and sigma_x by
    (7.27) comes out a/3 too short.
    """
    spring = 1.0 / (1.0 / c_cx + a / (3.0 * stiffness)) if stiffness > 0.0 else c_cx
    sigma = stiffness / spring + a
    return {"c_cx": c_cx / spring - 1.0, "sigma_x": -a / (3.0 * sigma)}


def form_error(state: JointState, bias: float, error: float) -> float:
    """Part of the standard error of c_cx [N/m] that the form of the model adds.

    It is half of the difference of c_cx between driving and braking steps, as far as scatter
    (`error`) does not explain it: after a large step the patch of (7.17) lags, and c_cx comes out
    too stiff for one sign and too soft for the other. With steps of one sign it is half of `bias`.
    """
    kappa = state.problem.curve.kappa[state.problem.level]
    if not (np.any(kappa > 0.0) and np.any(kappa < 0.0)):
        return 0.5 * abs(bias) * state.c_cx
    driving, braking = (state.stiffness_of(side) for side in (kappa >= 0.0, kappa <= 0.0))
    return math.sqrt(max(0.25 * (driving - braking) ** 2 - error**2, 0.0))


def _error(
    gradient: np.ndarray, runs: Sequence[StepRun], state: JointState, noise: ARNoise
) -> tuple[float, float]:
    """Standard error and degrees of freedom of a quantity with this gradient by (c_cx, forces).

    They follow from the contribution of each run. Where nothing was repeated, the standard error
    is at least that by the noise.
    """
    sensitivity = state.sensitivity(gradient)
    correction = _repeat_correction(state.problem.curve)
    brought = np.sum(sensitivity * state.error, axis=1)
    error = float(np.sqrt(np.sum(brought**2) * correction))
    if np.all(state.problem.curve.repeats < 2):
        error = max(error, noise_error(runs, state, sensitivity, noise))
    share = np.sum(sensitivity**2, axis=1)
    effective = np.sum(share) ** 2 / max(float(np.sum(share**2)), 1e-300)
    return error, float(max(effective / correction, 2.0))


def _curve_errors(state: JointState) -> np.ndarray:
    """Standard error of every level of the steady curve (k,) [N]; NaN without repeats."""
    curve = state.problem.curve
    unit = np.eye(len(curve.force) + 1)[1:]
    brought = np.array([np.sum(state.sensitivity(u) * state.error, axis=1) for u in unit])
    error = np.sqrt(np.sum(brought**2, axis=1) * _repeat_correction(curve))
    return np.where(curve.repeats > 1, error, np.nan)


def _repeat_correction(curve: SteadyCurve) -> float:
    """Factor n / (n - 1) on a sum of squares: each of n repeats is a part of their mean."""
    n = float(np.mean(curve.repeats))
    return n / (n - 1.0) if n > 1.0 else 1.0


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


def _confusions(
    runs: Sequence[StepRun], curve: SteadyCurve, lack: str, edge: str
) -> tuple[Confusion, ...]:
    found = []
    if len({run.start for run in runs}) < 2:
        names = ("run-to-run scatter", "once-per-turn error")
        text = "one start angle only: scatter between runs and an error that turns with the wheel "
        text += "cannot be told from the tire's response"
        found.append(Confusion(names, 1.0, text, "repeat the slips at a start angle of 120 deg"))
    elif np.all(curve.repeats < 2):
        found.append(NOT_REPEATED)
    if lack:
        text = f"{len(curve.kappa)} slip levels do not tell the slope of the steady curve at zero"
        text += " slip from its bend: slip stiffness and relaxation length come out too small, "
        text += "the carcass too stiff"
        names = ("slip_stiffness", "bend of the steady curve")
        found.append(Confusion(names, 1.0, text, f"add {lack}"))
    if edge:
        text = f"c_cx rests on its {edge} bound: the response does not show the carcass"
        remedy = "add steps of 2 to 5 % slip, which load the carcass most"
        found.append(Confusion(("c_cx", "tread stiffness"), 1.0, text, remedy))
    return tuple(found)
