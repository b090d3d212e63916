# SPDX-License-Identifier: Apache-2.0
"""One slip level of one operating point: mean of its runs (section 6.2), its linear model, and
further results of the runs: stiffness at rest, drive torque, side force.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from flatplank_analysis.identify.lateral import lateral_run
from flatplank_analysis.identify.linear import LinearFit, is_transient, linear_run
from flatplank_analysis.identify.repeats import has_mean, mean_response
from flatplank_analysis.identify.runs import StepRun
from flatplank_analysis.post.gridding import (
    SPACING,
    Gridded,
    bin_means,
    low_pass,
    mean_of_starts,
    on_grid,
    repeat_std,
)
from flatplank_analysis.post.motion import StepFacts, step_facts
from flatplank_analysis.report.floors import floor_of_runs, share_in_mean
from flatplank_analysis.report.results import ConditionResult, DriveRun, LateralResult, RestRun
from flatplank_analysis.starts import mean_over_starts, value_over_starts
from flatplank_analysis.steady.stiffness import static_longitudinal_stiffness
from flatplank_analysis.steady.transmission import drive_state
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError
from flatplank_data.lost import lost_samples
from flatplank_data.table import MeasurementTable

SHOWN = ("fx", "fy", "fz", "plank_velocity")
THIN = 20
"""every 20th point of the 0.1 mm grid is kept after the filter: 2 mm"""
TAIL = 0.5
"""road over which a steady lateral force is averaged [m]"""
SMALLEST_ANGLE = 0.3
"""smallest slip angle of a lateral step [deg]"""
LATERAL_SPACING = 0.01
"""grid spacing of the mean lateral force [m]"""


def condition_result(condition: Condition, tables: Sequence[MeasurementTable]) -> ConditionResult:
    """Mean of the runs, low-passed (section 6.2), and its linear model (7.11, 7.12)."""
    step = tables[0].info.step_position
    if not math.isfinite(step):
        file = tables[0].info.file
        raise FlatplankError("no step_position", file, "add it to campaign.yaml [m]")
    gridded = [on_grid(t, SHOWN) for t in tables]
    starts = [t.info.start for t in tables]
    mean = mean_of_starts(gridded, starts).map(low_pass)
    repeats = _repeats(gridded, starts)
    facts = mean_facts([step_facts(t) for t in tables], starts)
    kappa = facts.kappa_actual if math.isfinite(facts.kappa_actual) else condition.kappa
    good = np.isfinite(mean["fx"])
    tail = mean["fy"][np.isfinite(mean["fy"])] if "fy" in mean.columns else np.zeros(0)
    tail = tail[-round(TAIL / SPACING) :]
    scatter = None
    if len(repeats) > 1:
        scatter = repeat_std([g.map(low_pass, ["fx"]) for g in repeats], "fx")[::THIN]
    thin = slice(None, None, THIN)
    fit = linear_run(mean.position[good] - step, mean["fx"][good], kappa)
    return ConditionResult(
        condition,
        [t.info.name for t in tables],
        facts,
        step,
        mean.position[thin],
        {name: values[thin] for name, values in mean.columns.items()},
        scatter,
        len(repeats) < len(gridded) or len(set(starts)) == 1,
        fit,
        {t.info.name: _run_fit(t, step) for t in tables},
        float(tail.mean()) if tail.size else math.nan,
        sum(lost_samples(t).lost for t in tables),
        _floor(gridded, tables, step, fit.transient_end),
        share_in_mean(starts),
    )


def _floor(
    gridded: Sequence[Gridded], tables: Sequence[MeasurementTable], step: float, end: float
) -> float:
    """Floor of the runs in the transient part [N]: filtered forces from the step on."""
    turned = [on_grid(t, ("wheel_angle",)) for t in tables]
    if not all("wheel_angle" in t.columns for t in turned):
        return math.nan
    force = np.stack([low_pass(g["fx"])[::THIN] for g in gridded])
    angle = np.stack([t["wheel_angle"][::THIN] for t in turned])
    angle += np.array([[t.info.start_angle - t["wheel_angle"][0]] for t in tables])
    since = gridded[0].position[::THIN] - step
    used = (since >= 0.0) & np.isfinite(force).all(axis=0) & np.isfinite(angle).all(axis=0)
    return floor_of_runs(force[:, used], angle[:, used], is_transient(since[used], end))


def _run_fit(table: MeasurementTable, step: float) -> LinearFit:
    facts = step_facts(table)
    kappa = facts.kappa_actual if math.isfinite(facts.kappa_actual) else table.info.kappa
    return linear_run(table["plank_position"] - step, table["fx"], kappa)


def _repeats(runs: Sequence[Gridded], starts: Sequence[int]) -> list[Gridded]:
    """Runs whose scatter is shown: those of a repeated start angle, otherwise all."""
    counts = {s: starts.count(s) for s in starts}
    most = max(counts, key=lambda s: counts[s])
    uneven = counts[most] > 2 and len(set(counts.values())) > 1
    return [r for r, s in zip(runs, starts, strict=True) if s == most or not uneven]


def mean_facts(facts: Sequence[StepFacts], starts: Sequence[int]) -> StepFacts:
    """Mean over the start angles, each the mean of its runs, as for the forces."""
    names = [f.name for f in dataclasses.fields(StepFacts)]
    found = {n: value_over_starts([getattr(f, n) for f in facts], starts).value for n in names}
    return StepFacts(**found)


def further_results(
    tables: Sequence[MeasurementTable],
) -> tuple[list[RestRun], list[DriveRun], list[StepRun]]:
    """Further results of slip runs, where they were measured.

    Returns C_x of the standing tire, torques at the end of the run, and starts of rolling at a
    slip angle, as steps in side slip.
    """
    stiffness, drive, lateral = [], [], []
    for table in tables:
        if all(table.has(name) for name in ("wheel_angle", "fx", "plank_position")):
            value = static_longitudinal_stiffness(table)
            if math.isfinite(value):
                stiffness.append(RestRun(value, table.info.start))
        if table.has("motor_torque") and table.has("motor_velocity"):
            drive.append(DriveRun(table.info.condition, drive_state(table), table.info.start))
        if abs(table.info.alpha_deg) >= SMALLEST_ANGLE and table.has("fy"):
            with contextlib.suppress(FlatplankError):
                lateral.append(lateral_run(table))
    return stiffness, drive, lateral


def lateral_result(runs: Sequence[StepRun]) -> LateralResult | None:
    """First-order response of the mean of the runs."""
    if not runs:
        return None
    if has_mean(runs):
        mean = mean_response(runs)
        fit, error = mean.fit, [float(v) for v in mean.std_error]
    else:
        fit = linear_run(runs[0].distance, runs[0].fx, runs[0].kappa)
        error = [math.nan, math.nan, math.nan]
    last = min(float(run.distance[-1]) for run in runs)
    x = runs[0].distance[runs[0].distance <= last]
    forces = [np.interp(x, run.distance, -run.fx) for run in runs]
    force = mean_over_starts(forces, [run.start for run in runs])
    thin, (kept,) = bin_means(x, force[None], LATERAL_SPACING)
    return LateralResult(fit, error, len(runs), thin, kept)
