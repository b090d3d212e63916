# SPDX-License-Identifier: Apache-2.0
"""Reads back what was recorded and says what it is worth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.calibration.fit_check import still_fits
from flatplank_control.runner.campaign.conductor import Job, Outcome
from flatplank_control.runner.campaign.quality import Finding, Limits, judge, profile, travel
from flatplank_control.runner.campaign.stiffness import EVALUATIONS
from flatplank_control.runner.conditions import PRELOAD
from flatplank_control.runner.moves import ENOUGH
from flatplank_control.runner.standstill import Standstill
from flatplank_control.runner.turn_watch import TurnWatch
from flatplank_data.campaign import Run
from flatplank_data.readers import describe
from flatplank_data.run_record import RunRecord
from flatplank_data.store import open_store
from flatplank_data.table import MeasurementTable

COLUMNS = [
    "time", "plank_position", "plank_velocity", "wheel_angle", "motor_velocity", "fx", "fy", "fz",
    "loaded_radius",
]  # fmt: skip
STOOD = 0.02
"""a wheel that turned by less stood [rad]"""
ZERO_LIMIT = 60.0
"""change of the hub's zero over a run [N]"""


def read(path: Path) -> MeasurementTable:
    """The samples of a bag or a table from the trigger on."""
    return Run(RunRecord(file=path.name), open_store(path.parent)).table(COLUMNS)


def outcome_of(
    path: Path,
    job: Job,
    limits: Limits,
    before: Standstill,
    after: Standstill,
    turn: TurnWatch | None = None,
) -> Outcome:
    """Verdict, effective rolling radius of a free-rolling run, zeros."""
    table = read(path)
    enough = ENOUGH in str(describe(open_store(path.parent), path.name).get("stop_reason", ""))
    verdict = judge(table.columns, job.measurement, limits, job.earlier, enough)
    facts: dict[str, Any] = {
        "profile": profile(table.columns), "travel": round(travel(table.columns), 3),
    }  # fmt: skip
    zeros: list[Finding] = []
    if before.fx and after.fx:
        change = max(abs(b - a) for b, a in zip(before.zero, after.zero, strict=True))
        # without the filter the preloaded shaft turns the zero with the wheel
        turned = float(abs(table.columns["wheel_angle"][-1] - table.columns["wheel_angle"][0]))
        hidden = 0.0 if after.filter_on or turned < STOOD else PRELOAD
        zeros = [Finding("zero_change", change, ZERO_LIMIT + hidden)]
        facts |= {"before": before.facts(), "after": after.facts()}
    if turn is not None and turn.left == turn.left:
        facts["once_per_turn_unloaded"] = round(turn.left, 1)
        if turn.filter_on and (warning := still_fits(turn.left)):
            facts["warnings"] = [warning]
    evaluate = EVALUATIONS.get(job.measurement.measurement)
    if evaluate is not None:
        found_values = evaluate(table.columns, job.measurement)
        facts |= {name: float(f"{value:.6g}") for name, value in found_values.items()}
    if job.measurement.measurement == "free_rolling":
        found = radius_of_run(table)
        facts |= {"radius": found.radius, "radius_force": found.force}
    return Outcome(path.name, replace(verdict, findings=(*verdict.findings, *zeros)), facts)
