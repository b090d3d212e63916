# SPDX-License-Identifier: Apache-2.0
"""From a campaign to its results: one job per operating point, in parallel."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from flatplank_analysis.identify.carcass import fit_carcass
from flatplank_analysis.identify.mf.points import points_from_runs
from flatplank_analysis.identify.runs import StepRun, step_run
from flatplank_analysis.models.base import TOYO, ContactGeometry
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.pages.provenance import provenance
from flatplank_analysis.parallel import open_executor
from flatplank_analysis.report.conditions import condition_result, further_results, lateral_result
from flatplank_analysis.report.extras import other_measurements
from flatplank_analysis.report.models import fit_points, linear_curves, mf_curves, nonlinear_curves
from flatplank_analysis.report.results import (
    CampaignResult,
    ConditionResult,
    FurtherResults,
    PointResult,
)
from flatplank_analysis.report.steps import COLUMNS as STEP_COLUMNS
from flatplank_analysis.report.steps import extras_as_points, read_each_run
from flatplank_analysis.report.tire import geometry_of, record_for, tires_of
from flatplank_analysis.steady.rolling_radius import RadiusRun, radius_of_run
from flatplank_data.campaign import Campaign, Run
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.problem import Problem, problem_from_error
from flatplank_data.table import MeasurementTable

COLUMNS = (*STEP_COLUMNS, "motor_torque", "loaded_radius")
POINT_MEASUREMENTS = ("slip", "free_rolling")

Progress = Callable[[int, int, str], None]
"""receives the number of jobs done, of all jobs, and the label of the job just done"""


@dataclass(frozen=True)
class PointJob:
    """The runs of one operating point."""

    point: Condition
    runs: Sequence[Run]
    nonlinear: bool = True
    geometry: ContactGeometry = TOYO


def analyse(
    campaign: Campaign,
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    nonlinear: bool = True,
    magic: bool = True,
    progress: Progress | None = None,
    tire: TireRecord | None = None,
) -> CampaignResult:
    """All results of a campaign; `tire`: by default the record found by `record_for`.

    Raises NothingUsableError when no run could be used.
    """
    record = tire or record_for([campaign])
    extras = other_measurements(campaign, free_radius=record.free_radius)
    geometry = geometry_of(extras, record)
    work = point_jobs(campaign, nonlinear, geometry.contact)
    points: list[PointResult] = []
    with open_executor(jobs, scheduler) as executor:
        for done, result in enumerate(executor.map(analyse_point, work), start=1):
            points.append(result)
            for problem in result.problems:
                campaign.add_problem(problem)
            if progress:
                progress(done, len(work), result.point.label())
    if not any(p.conditions or p.radii for p in points) and not extras:
        first = f" (first: {campaign.problems[0]})" if campaign.problems else ""
        raise NothingUsableError(
            f"no run could be used{first}", campaign.path, "see the problems of its files"
        )
    problems = tuple(campaign.problems)
    names = tires_of([campaign])
    name = campaign.tire or (names[0] if names else record.name)
    whole = CampaignResult(
        campaign.path, name, points, problems, extras, geometry=geometry, record=record,
        about=provenance(campaign.records()),
    )  # fmt: skip
    if len(names) > 1:
        why = f"runs of {len(names)} tires ({', '.join(names)}): make one report for each"
        return dataclasses.replace(whole, why_no_magic=why)
    return _with_magic(whole) if magic else whole


def _with_magic(result: CampaignResult) -> CampaignResult:
    """Add the Magic Formula fitted to all points, and its response to every step."""
    extra = extras_as_points(result.extras, result.radii, result.points)
    assert result.record is not None
    found = fit_points(result.points, extra, result.record)
    if isinstance(found, str):
        return dataclasses.replace(result, why_no_magic=found)
    points = [
        dataclasses.replace(p, models={**p.models, **mf_curves(found, p)}) if p.conditions else p
        for p in result.points
    ]
    return dataclasses.replace(result, points=points, magic=found)


def point_jobs(
    campaign: Campaign, nonlinear: bool = True, geometry: ContactGeometry = TOYO
) -> list[PointJob]:
    """Rolling runs by operating point; free-rolling runs belong to the slip runs of their
    point."""
    groups: dict[Condition, list[Run]] = {}
    for condition, runs in campaign.conditions().items():
        if condition.measurement in POINT_MEASUREMENTS:
            point = condition.operating_point._replace(measurement="slip")
            groups.setdefault(point, []).extend(runs)
    return [PointJob(point, tuple(runs), nonlinear, geometry) for point, runs in groups.items()]


def analyse_point(job: PointJob) -> PointResult:
    """Read the runs of one operating point, condition by condition, and fit the models."""
    problems: list[Problem] = []
    conditions: list[ConditionResult] = []
    steps: list[StepRun] = []
    radii: list[RadiusRun] = []
    groups: dict[Condition, list[Run]] = {}
    for run in job.runs:
        groups.setdefault(run.info.condition, []).append(run)
    more: tuple[list, list, list] = ([], [], [])
    for condition, runs in groups.items():
        tables: list[MeasurementTable] = []
        problems += read_each_run(runs, partial(_keep, tables), COLUMNS)
        rolled = [t for t in tables if t.has("wheel_angle") or t.has("motor_velocity")]
        found_radii = _results_of(problems, radius_of_run, rolled)
        radii += [r for r in found_radii if math.isfinite(r.radius)]
        if condition.measurement == "slip" and tables:
            stiffness, drive, lateral = further_results(tables)
            more[0].extend(stiffness)
            more[1].extend(drive)
            more[2].extend(lateral)
            found = _guarded(problems, condition_result, condition, tables)
            if found is not None:
                conditions.append(found)
                steps += _results_of(problems, step_run, tables)
    carcass, why, models = None, "", {}
    if conditions:
        models["linear"] = linear_curves(conditions)
    if job.nonlinear and steps:
        try:
            carcass = fit_carcass(steps, geometry=job.geometry)
            models["nonlinear"] = nonlinear_curves(carcass, conditions, steps, job.geometry)
        except FlatplankError as error:
            why = str(error)
    steady = points_from_runs(steps) if steps else None
    side = FurtherResults(more[0], more[1], lateral_result(more[2]))
    return PointResult(
        job.point, conditions, radii, carcass, why, models, tuple(problems), steady, side
    )


def _keep(tables: list[MeasurementTable], _: Run, table: MeasurementTable) -> None:
    tables.append(table)


def _guarded(problems: list[Problem], function: Callable, *args: object, file: str = ""):
    """Result of the function; when it fails, None, and the reason is added to the problems."""
    try:
        return function(*args)
    except FlatplankError as error:
        problems.append(problem_from_error(error, file or error.where.split(",")[0]))
        return None


def _results_of(
    problems: list[Problem], function: Callable, tables: Iterable[MeasurementTable]
) -> list:
    """Results of a function for the tables that it can use."""
    found = (_guarded(problems, function, t, file=t.info.file) for t in tables)
    return [value for value in found if value is not None]
