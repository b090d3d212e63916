# SPDX-License-Identifier: Apache-2.0
"""Input of the fits from campaigns: step runs, and steady points from other measurements."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from flatplank_analysis.identify.carcass import CarcassFit
from flatplank_analysis.identify.lateral import lateral_run
from flatplank_analysis.identify.mf.points import AT_REST, SteadyPoints, steady_points
from flatplank_analysis.identify.repeats import mean_fit
from flatplank_analysis.identify.runs import StepRun, by_level, by_operating_point, step_run
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.parallel import Executor
from flatplank_analysis.post.motion import until_stop
from flatplank_analysis.report.extras import inside_window, other_measurements
from flatplank_analysis.report.results import PointResult
from flatplank_analysis.steady.rolling_radius import RadiusRun, mean_radii, radius_of_run
from flatplank_data.campaign import Campaign, Run
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.identity import KnownRuns, copy_of
from flatplank_data.problem import Problem, problem_from_error
from flatplank_data.table import MeasurementTable

COLUMNS = (
    "time",
    "plank_position",
    "plank_velocity",
    "wheel_angle",
    "wheel_velocity",
    "motor_velocity",
    "fx",
    "fy",
    "fz",
    "mz",
)
Group = tuple[list[StepRun], list[RadiusRun], list[Problem]]


def read_each_run(
    runs: Sequence[Run],
    take: Callable[[Run, MeasurementTable], None],
    columns: Sequence[str] = COLUMNS,
) -> list[Problem]:
    """Read every run and pass its table, up to the stop, to `take`; return all problems."""
    problems: list[Problem] = []
    known = KnownRuns()
    for run in runs:
        try:
            table, remarks = run.read(columns)
            problems += remarks
            copied = copy_of(table, known)
            if copied is not None:
                problems.append(copied)
                continue
            take(run, until_stop(table))
        except FlatplankError as error:
            problems.append(problem_from_error(error, run.info.file))
    return problems


def read_lateral(runs: Sequence[Run]) -> Group:
    """Lateral runs, from the start of rolling to the slip step."""
    starts: list[StepRun] = []

    def take(run: Run, table: MeasurementTable) -> None:
        if table.has("fy"):
            starts.append(lateral_run(table))

    problems = read_each_run([run for run in runs if run.info.measurement == "slip"], take)
    return starts, [], problems


def read_group(runs: Sequence[Run]) -> Group:
    """Step runs and rolling radii of some runs."""
    steps: list[StepRun] = []
    radii: list[RadiusRun] = []

    def take(run: Run, table: MeasurementTable) -> None:
        radii.append(radius_of_run(table))
        if run.info.is_step:
            steps.append(step_run(table))

    problems = read_each_run(runs, take)
    return steps, [r for r in radii if math.isfinite(r.radius)], problems


def read_steps(
    campaigns: Sequence[Campaign],
    executor: Executor,
    read: Callable[[Sequence[Run]], Group] = read_group,
) -> tuple[list[StepRun], list[RadiusRun]]:
    """All step runs and rolling radii of campaigns, read in parallel by operating point.

    Raises NothingUsableError without a usable step run.
    """
    steps: list[StepRun] = []
    radii: list[RadiusRun] = []
    for campaign in campaigns:
        groups: dict[Condition, list[Run]] = {}
        for run in campaign.runs:
            if run.info.kind in ("slip", "free_rolling"):
                groups.setdefault(run.info.condition.operating_point, []).append(run)
        for found, rolled, problems in executor.map(read, list(groups.values())):
            steps += found
            radii += rolled
            for problem in problems:
                campaign.add_problem(problem)
    if not steps:
        first = next((p for c in campaigns for p in c.problems), None)
        what = "no slip-step run could be used" + (f" (first: {first})" if first else "")
        raise NothingUsableError(what, campaigns[0].path, "see the problems of its files")
    return steps, radii


def extra_points(
    campaigns: Sequence[Campaign],
    steps: Sequence[StepRun],
    radii: Sequence[RadiusRun],
    fits: Sequence[CarcassFit],
    record: TireRecord,
) -> list[SteadyPoints]:
    """Points of a Magic Formula fit from other measurements of the campaigns.

    They are the rolling radius at Fx = 0, deflection, size of the contact, C_x and C_y at rest.
    """
    known = {f.operating_point: f.slip_stiffness for f in fits if f.slip_stiffness.determined}
    stiffness = small_slip_stiffness(steps) | {c: e.value for c, e in known.items()}
    out = radius_points(radii, stiffness)
    for campaign in campaigns:
        out += _points_of(other_measurements(campaign, free_radius=record.free_radius))
    return out


def extras_as_points(
    extras: Mapping[str, Any], radii: Sequence[RadiusRun], points: Sequence[PointResult]
) -> list[SteadyPoints]:
    """Points as those of `extra_points`, from existing results."""
    stiffness = {p.point: slip_stiffness(p) for p in points}
    return [*radius_points(radii, stiffness), *_points_of(extras)]


def _points_of(found: Mapping[str, Any]) -> list[SteadyPoints]:
    out = []
    for run in found.get("vertical_stiffness", []):
        radius, fz, free = inside_window(run)
        number = np.zeros(len(fz))
        deflection = {"rho": free - radius}
        out.append(steady_points(deflection, fz=fz, pressure=1e5 * run["pressure"], run=number))
    prints = found.get("footprints")
    if prints is not None:
        measured = {"a": prints["half_length"], "b": prints["half_width"]}
        pressure = 1e5 * prints["pressure"]
        out.append(steady_points(measured, fz=prints["fz"], pressure=pressure))
    for quantity, output in (("C_y", "cy"), ("C_x", AT_REST)):
        rows = [r for r in found.get("standing", []) if r["quantity"] == quantity]
        rows = [r for r in rows if not r["gamma_deg"]]
        if rows:
            fz, bar, value = (np.array([r[k] for r in rows]) for k in ("fz", "pressure", "value"))
            out.append(steady_points({output: value}, fz=fz, pressure=1e5 * bar))
    return out


def slip_stiffness(point: PointResult) -> float:
    """C_Fk of a point [N]: from the nonlinear fit, otherwise from the smallest slips; or NaN."""
    if point.carcass is not None and point.carcass.slip_stiffness.determined:
        return point.carcass.slip_stiffness.value
    fits = sorted(
        (c for c in point.conditions if c.linear.slip_stiffness.determined),
        key=lambda c: abs(c.condition.kappa),
    )[:2]
    values = [c.linear.slip_stiffness.value for c in fits]
    return sum(values) / len(values) if values else math.nan


def small_slip_stiffness(steps: Sequence[StepRun]) -> dict[object, float]:
    """C_Fk per operating point [N]: linear fits of the means at the smallest slips."""
    out = {}
    for condition, runs in by_operating_point(s for s in steps if s.level).items():
        least = min(abs(run.level) for run in runs)
        levels = by_level(run for run in runs if abs(run.level) < 1.01 * least).values()
        values = [mean_fit(members).slip_stiffness.value for members in levels]
        out[condition] = sum(values) / len(values)
    return out


def radius_points(
    radii: Sequence[RadiusRun], stiffness: Mapping[Any, float]
) -> list[SteadyPoints]:
    """r_e at Fx = 0, a row per operating point and source that has a slip stiffness."""
    known = [v for v in mean_radii(radii, stiffness) if math.isfinite(v.slip_stiffness)]
    if not known:
        return []
    rows = [(v.load, 1e5 * v.point.pressure, v.point.alpha_deg, v.point.gamma_deg) for v in known]
    fz, pressure, alpha, gamma = np.array(rows).T
    measured = {"re": np.array([v.corrected.value for v in known])}
    angles = {"alpha": np.radians(alpha), "gamma": np.radians(gamma)}
    return [steady_points(measured, fz=fz, pressure=pressure, **angles)]
