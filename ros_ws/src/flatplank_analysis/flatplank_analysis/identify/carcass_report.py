# SPDX-License-Identifier: Apache-2.0
"""What the carcass fit says and how sure it is: noise, scatter, and the steady curve's share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from .carcass_joint import JointState, noise_error, repeat_noise
from .carcass_problem import CarcassProblem
from .linear import LinearFit
from .noise import ARNoise
from .quality import is_transient
from .results import Confusion, Estimate, plain_condition, to_plain
from .runs import StepRun
from .steady_curve import SteadyCurve, slope_lack


class Operating(NamedTuple):
    """Means over the runs of a fit; SI."""

    fz: float
    pressure: float
    alpha: float
    gamma: float


@dataclass(frozen=True)
class CarcassFit:
    """Result of the nonlinear model for one condition."""

    condition: Any
    c_cx: Estimate
    slip_stiffness: Estimate
    """C_Fkappa: slope of the steady curve at zero slip [N]."""
    sigma_x: Estimate
    """Relaxation length (7.27) [m]."""
    model_bias: dict[str, float]
    """The model's own relative bias of c_cx and sigma_x where the tread is made of bristles."""
    half_length: float
    """a at the mean load [m]."""
    curve: SteadyCurve
    rmse: dict[float, float]
    """Per nominal slip: root-mean-square error in the transient part [N]."""
    runs: int
    at: Operating
    confusions: tuple[Confusion, ...] = ()
    converged: bool = True
    beside: tuple[Estimate, ...] = ()
    """What was fitted with them: in y the steering zero."""

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Carcass stiffness, slip stiffness, relaxation length; in y under names of their own."""
        return (self.c_cx, self.slip_stiffness, self.sigma_x, *self.beside)

    def without_bias(self) -> dict[str, Estimate]:
        """c_cx and sigma_x less the model's own bias, by the names of `model_bias`."""
        pairs = zip(self.model_bias.items(), (self.c_cx, self.sigma_x), strict=True)
        return {name: e.times(1.0 / (1.0 + bias)) for (name, bias), e in pairs}

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        free = self.without_bias()
        return {
            "condition": plain_condition(self.condition),
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
    a = float(problem.geometry.half_length(np.mean([r.mean_load for r in runs]), runs[0].pressure))
    gradients = {
        "c_cx": np.append(1.0, np.zeros_like(slope)),
        "slip_stiffness": np.append(0.0, slope),
        "sigma_x": np.append(-stiffness / c_cx**2, slope / c_cx),
    }
    values = {"c_cx": c_cx, "slip_stiffness": stiffness, "sigma_x": stiffness / c_cx + a}
    bias = brush_bias(c_cx, stiffness, a)
    noise = repeat_noise(runs, state)
    estimates = {
        name: _estimate(name, values[name], gradient, runs, state, noise, edge)
        for name, gradient in gradients.items()
    }
    spread = form_error(state, bias["c_cx"], estimates["c_cx"].std_error)
    forms = {
        "c_cx": spread,
        "slip_stiffness": found.form,
        "sigma_x": math.hypot(found.form, stiffness * spread / c_cx) / c_cx,
    }
    estimates = {
        name: replace(e, std_error=math.hypot(e.std_error, forms[name]))
        for name, e in estimates.items()
    }
    return CarcassFit(
        condition=runs[0].condition,
        model_bias=bias,
        half_length=a,
        curve=replace(problem.curve, std_error=_curve_errors(state)),
        rmse=_rmse_per_level(runs, fits, problem, problem.measured + state.error),
        runs=len(runs),
        at=Operating(
            *(
                float(np.mean(values))
                for values in zip(
                    *((r.mean_load, r.pressure, r.alpha, r.gamma) for r in runs), strict=True
                )
            )
        ),
        confusions=_confusions(runs, problem.curve, edge),
        converged=done,
        **estimates,
    )


def brush_bias(c_cx: float, stiffness: float, a: float) -> dict[str, float]:
    """Relative bias of the model on a tread of bristles, in the limit of small slip.

    After a small step such a tread lags by 2a/3 in the mean (a parabola over 2a), the model by
    sigma_c = a: the carcass gets the difference, 1/c_cx = 1/c - a/(3 C_Fk), and sigma_x by (7.27)
    comes out a/3 too short.
    """
    spring = 1.0 / (1.0 / c_cx + a / (3.0 * stiffness)) if stiffness > 0.0 else c_cx
    sigma = stiffness / spring + a
    return {"c_cx": c_cx / spring - 1.0, "sigma_x": -a / (3.0 * sigma)}


def form_error(state: JointState, bias: float, error: float) -> float:
    """What the form of the model adds to the standard error of c_cx [N/m], beside its bias.

    Half of what driving and braking steps disagree, as far as their scatter (`error`) does not
    explain it: after a large step the patch of (7.17) is late, to one side too stiff and to the
    other too soft. With steps of one sign half of the bias.
    """
    kappa = state.problem.curve.kappa[state.problem.level]
    if not (np.any(kappa > 0.0) and np.any(kappa < 0.0)):
        return 0.5 * abs(bias) * state.c_cx
    driving, braking = (state.stiffness_of(side) for side in (kappa >= 0.0, kappa <= 0.0))
    return math.sqrt(max(0.25 * (driving - braking) ** 2 - error**2, 0.0))


UNITS = {"c_cx": "N/m", "slip_stiffness": "N", "sigma_x": "m"}


def _estimate(
    name: str,
    value: float,
    gradient: np.ndarray,
    runs: Sequence[StepRun],
    state: JointState,
    noise: ARNoise,
    edge: str,
) -> Estimate:
    """Error from what each run brings; from the noise alone where nothing was repeated."""
    sensitivity = state.sensitivity(gradient)
    correction = _repeat_correction(state.problem.curve)
    brought = np.sum(sensitivity * state.error, axis=1)
    error = float(np.sqrt(np.sum(brought**2) * correction))
    if np.all(state.problem.curve.repeats < 2):
        error = max(error, noise_error(runs, state, sensitivity, noise))
    share = np.sum(sensitivity**2, axis=1)
    effective = np.sum(share) ** 2 / max(float(np.sum(share**2)), 1e-300)
    dof = float(max(effective / correction, 2.0))
    held = bool(edge) and name != "slip_stiffness"
    lack = slope_lack(state.problem.curve.kappa, state.problem.curve.force)
    known = not held and not lack
    note = f"not determined: needs {lack}" if lack else ""
    at_bound = edge if name == "c_cx" else ""
    return Estimate(name, value, UNITS[name], error, dof, at_bound, known, note=note)


def _curve_errors(state: JointState) -> np.ndarray:
    """Standard error of every level of the steady curve (k,) [N]; NaN without repeats."""
    curve = state.problem.curve
    unit = np.eye(len(curve.force) + 1)[1:]
    brought = np.array([np.sum(state.sensitivity(u) * state.error, axis=1) for u in unit])
    error = np.sqrt(np.sum(brought**2, axis=1) * _repeat_correction(curve))
    return np.where(curve.repeats > 1, error, np.nan)


def _repeat_correction(curve: SteadyCurve) -> float:
    """Small-sample factor: a mean of n repeats hides 1/n of their scatter."""
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
    lack = slope_lack(curve.kappa, curve.force)
    if lack:
        found.append(
            Confusion(
                ("slip_stiffness", "bend of the steady curve"),
                1.0,
                f"{len(curve.kappa)} slip levels do not tell the slope of the steady curve at zero"
                " slip from its bend: slip stiffness and relaxation length come out too small, "
                "the carcass too stiff",
                f"add {lack}",
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
