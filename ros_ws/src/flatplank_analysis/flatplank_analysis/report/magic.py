# SPDX-License-Identifier: Apache-2.0
"""MF-Tyre in the report: fitted in stages to the steady points, then run beside every step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from flatplank_analysis.identify.mf.fit import MFFit, fit_magic_formula
from flatplank_analysis.identify.mf.parameters import general_start
from flatplank_analysis.identify.mf.points import SteadyPoints, gathered
from flatplank_analysis.models.base import RunInputs, TransientModel, slip_inputs, stack_runs
from flatplank_analysis.models.magic_formula import Coefficients
from flatplank_analysis.models.mf_contact_point import ContactPointMF
from flatplank_analysis.models.mf_tyre import MFTyre
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.report.compare import compared, positions
from flatplank_analysis.report.results import ConditionResult, ModelCurves, PointResult
from flatplank_data.errors import FlatplankError

MIN_LEVELS = 5
"""slip levels of one operating point without which a Magic Formula says nothing"""


def fit_points(
    points: Sequence[PointResult], extra: Sequence[SteadyPoints], record: TireRecord
) -> MFFit | str:
    """The Magic Formula of a campaign from the start of its tire record, or why there is none."""
    parts = [p.steady for p in points if p.steady is not None]
    if max((len(p.conditions) for p in points), default=0) < MIN_LEVELS:
        return f"fewer than {MIN_LEVELS} slip levels at every operating point"
    found, source = gathered([*parts, *extra], [p.carcass for p in points if p.carcass])
    try:
        start = start_tir(record, general_start())
        return fit_magic_formula(found, start, cx_source=source)
    except FlatplankError as error:
        return str(error)


def _load(c: ConditionResult) -> float:
    return c.facts.fz_after if math.isfinite(c.facts.fz_after) else c.condition.fz


def mf_curves(fit: MFFit, point: PointResult) -> dict[str, ModelCurves]:
    """Models after the step of every condition, driven by actual slip and measured load.

    None where Fx or C_x is not known: another tire's would stand there.
    """
    coefficients = fit.tir.coefficients
    if "fx" not in fit.fits or not math.isfinite(coefficients.LONGITUDINAL_STIFFNESS):
        return {}
    inputs = stack_runs([_inputs(c) for c in point.conditions])
    out = {}
    for name, (title, model) in MODELS.items():
        responses = model(coefficients).simulate(np.empty((1, 0)), inputs)[0]
        curves, errors = {}, {}
        for c, response in zip(point.conditions, responses, strict=True):
            x = positions(c)
            curves[c.condition], errors[c.condition] = compared(c, x, response[: len(x)])
        out[name] = ModelCurves(name, title, curves, errors)
    return out


MODELS: dict[str, tuple[str, Callable[[Coefficients], TransientModel]]] = {
    "mf": ("MF-Tyre, constant σx", MFTyre),
    "mf_contact_point": ("MF-Tyre, contact point on the carcass spring", ContactPointMF),
}
"""Name in tables -> title, model of the fitted coefficients."""


def _inputs(c: ConditionResult) -> RunInputs:
    x = positions(c)
    load = np.full_like(x, _load(c))
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
