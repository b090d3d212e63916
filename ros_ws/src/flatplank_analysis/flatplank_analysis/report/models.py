# SPDX-License-Identifier: Apache-2.0
"""Models compared with measured steps: linear, nonlinear, MF-Tyre; same positions, same filter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from flatplank_analysis.identify.carcass import CarcassFit
from flatplank_analysis.identify.linear import is_transient
from flatplank_analysis.identify.mf.fit import MFFit, fit_magic_formula
from flatplank_analysis.identify.mf.points import SteadyPoints, merge_with_cx_source
from flatplank_analysis.identify.mf.stages import general_start
from flatplank_analysis.identify.results import rmse
from flatplank_analysis.identify.runs import StepRun
from flatplank_analysis.models.base import (
    ContactGeometry,
    RunInputs,
    TransientModel,
    slip_inputs,
    stack_runs,
)
from flatplank_analysis.models.mf_tyre import ContactPointMF, MFTyre
from flatplank_analysis.models.nonlinear import NonlinearX
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.post.gridding import SPACING, low_pass
from flatplank_analysis.report.results import ConditionResult, ModelCurves, PointResult
from flatplank_analysis.starts import mean_over_starts
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import Coefficients

LEAD = 0.1
"""road before the step on which the model is at rest, for the filter [m]"""
MODEL_SPACING = 0.005
"""grid spacing of the nonlinear model [m]"""
MIN_LEVELS = 5
"""least number of slip levels of one operating point for a Magic Formula"""
MF_MODELS: dict[str, tuple[str, Callable[[Coefficients], TransientModel]]] = {
    "mf": ("MF-Tyre, constant σx", MFTyre),
    "mf_contact_point": ("MF-Tyre, contact point on the carcass spring", ContactPointMF),
}
"""Name in tables -> title, model of the fitted coefficients."""


def positions(c: ConditionResult) -> np.ndarray:
    """Distances since the step [m] at which models are compared with the measured force."""
    return c.since_step[(c.since_step >= 0.0) & np.isfinite(c.measured["fx"])]


def beside_measured(
    name: str,
    title: str,
    conditions: Sequence[ConditionResult],
    response: Callable[[ConditionResult, np.ndarray], np.ndarray],
) -> ModelCurves:
    """A model's `response` [N] at positions, filtered like the data, with its errors."""
    curves, errors = {}, {}
    for c in conditions:
        x = positions(c)
        fine = np.arange(-LEAD, x[-1] + SPACING, SPACING)
        # before the step the model is at rest
        start = c.linear.start_force.value
        values = np.where(fine < 0.0, start, np.interp(fine, x, response(c, x)))
        curve = np.interp(x, fine, low_pass(values))
        seen = np.interp(x, c.since_step, c.measured["fx"])
        curves[c.condition] = (x, curve)
        errors[c.condition] = rmse(seen, curve, is_transient(x, c.linear.transient_end))
    return ModelCurves(name, title, curves, errors)


def linear_curves(conditions: Sequence[ConditionResult]) -> ModelCurves:
    """The linear model of every condition."""
    title = "linear transient model"
    return beside_measured("linear", title, conditions, lambda c, x: c.linear.response(x))


def nonlinear_curves(
    fit: CarcassFit,
    conditions: Sequence[ConditionResult],
    steps: Sequence[StepRun],
    geometry: ContactGeometry,
) -> ModelCurves:
    """The nonlinear model of every condition: mean of its runs' responses."""
    law = fit.curve.law()
    load = float(mean_over_starts([r.mean_load for r in steps], [r.start for r in steps]))
    mu = float(np.max(np.abs(fit.curve.force))) / load
    model = NonlinearX(lambda _: law, geometry, mu)
    stiffness = np.array([[fit.c_cx.value]])

    def response(c: ConditionResult, x: np.ndarray) -> np.ndarray:
        parts = []
        own = [s for s in steps if s.level == c.condition.kappa]
        for run in own:
            grid, _ = run.grid(MODEL_SPACING, run.fx[None])
            inputs = run.inputs(MODEL_SPACING, c.linear.start_force.value)
            parts.append(np.interp(x, grid, model.simulate(stiffness, inputs)[0, 0]))
        return mean_over_starts(parts, [run.start for run in own])

    return beside_measured("nonlinear", "nonlinear transient model", conditions, response)


def fit_points(
    points: Sequence[PointResult], extra: Sequence[SteadyPoints], record: TireRecord
) -> MFFit | str:
    """The Magic Formula of a campaign, started from its tire record, or the reason for none."""
    parts = [p.steady for p in points if p.steady is not None]
    if max((len(p.conditions) for p in points), default=0) < MIN_LEVELS:
        return f"fewer than {MIN_LEVELS} slip levels at every operating point"
    found, source = merge_with_cx_source(
        [*parts, *extra], [p.carcass for p in points if p.carcass]
    )
    try:
        start = start_tir(record, general_start())
        return fit_magic_formula(found, start, cx_source=source)
    except FlatplankError as error:
        return str(error)


def mf_curves(fit: MFFit, point: PointResult) -> Mapping[str, ModelCurves]:
    """Models after the step of every condition, driven by actual slip and measured load.

    Empty where Fx or C_x is not known, because the curves would be those of another tire.
    """
    coefficients = fit.tir.coefficients
    if "fx" not in fit.fits or not math.isfinite(coefficients.LONGITUDINAL_STIFFNESS):
        return {}
    inputs = stack_runs([_inputs(c) for c in point.conditions])
    out = {}
    for name, (title, model) in MF_MODELS.items():
        rows = model(coefficients).simulate(np.empty((1, 0)), inputs)[0]
        found = {c.condition: row for c, row in zip(point.conditions, rows, strict=True)}
        out[name] = beside_measured(name, title, point.conditions, partial(_row_of, found))
    return out


def _row_of(rows: Mapping[Condition, np.ndarray], c: ConditionResult, x: np.ndarray) -> np.ndarray:
    return rows[c.condition][: len(x)]


def _inputs(c: ConditionResult) -> RunInputs:
    x = positions(c)
    fz = c.facts.fz_after if math.isfinite(c.facts.fz_after) else c.condition.fz
    load = np.full_like(x, fz)
    if "fz" in c.measured:
        load = np.interp(x, c.since_step, c.measured["fz"])
    kappa = c.facts.kappa_actual if math.isfinite(c.facts.kappa_actual) else c.condition.kappa
    return slip_inputs(
        x,
        kappa,
        load,
        alpha=math.radians(c.condition.alpha_deg),
        gamma=math.radians(c.condition.gamma_deg),
        pressure=1e5 * c.condition.pressure,
        start_fx=c.linear.start_force.value,
        start_fy=c.lateral_steady if math.isfinite(c.lateral_steady) else 0.0,
    )
