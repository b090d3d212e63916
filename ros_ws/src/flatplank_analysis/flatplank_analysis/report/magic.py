# SPDX-License-Identifier: Apache-2.0
"""MF-Tyre in the report: fitted in stages to the steady points, then run beside every step."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flatplank_analysis.errors import FlatplankError
from flatplank_analysis.identify.mf.fit import MFFit, fit_magic_formula
from flatplank_analysis.identify.mf.parameters import general_start
from flatplank_analysis.identify.mf.points import SteadyPoints, gathered
from flatplank_analysis.models.base import slip_inputs
from flatplank_analysis.models.mf_tyre import MFTyre
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.report.compare import compared, positions
from flatplank_analysis.report.results import ConditionResult, ModelCurves, PointResult

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


def mf_curves(fit: MFFit, point: PointResult) -> ModelCurves:
    """MF-Tyre after the step of every condition, driven by actual slip and measured load."""
    model = MFTyre(fit.tir.coefficients)
    curves, errors = {}, {}
    for c in point.conditions:
        x = positions(c)
        load = np.full_like(x, _load(c))
        if "fz" in c.measured:
            load = np.interp(x, c.since_step, c.measured["fz"])
        kappa = c.facts.kappa_actual if math.isfinite(c.facts.kappa_actual) else c.condition.kappa
        inputs = slip_inputs(
            x,
            kappa,
            load,
            alpha=math.radians(c.condition.alpha_deg),
            gamma=math.radians(c.condition.gamma_deg),
            pressure=1e5 * c.condition.pressure,
            start_fx=c.linear.start_force.value,
            start_fy=c.lateral_steady if math.isfinite(c.lateral_steady) else 0.0,
        )
        response = model.simulate(np.empty((1, 0)), inputs)[0, 0]
        curves[c.condition], errors[c.condition] = compared(c, x, response)
    return ModelCurves("mf", "MF-Tyre", curves, errors)
