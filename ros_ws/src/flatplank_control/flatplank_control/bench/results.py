# SPDX-License-Identifier: Apache-2.0
"""Results of a campaign beside its data: verdicts of runs, campaign.yaml and tire.yaml."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from flatplank_analysis.models.tire_record import FILE as RECORD
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.calibration.book import FREE
from flatplank_control.calibration.fits import mounting_warning
from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_control.runner.campaign.conductor import FILTER_ON, Conductor, Job, Outcome
from flatplank_control.runner.campaign.quality import (
    EVALUATIONS,
    Finding,
    Limits,
    Verdict,
    force_profile,
    judge_run,
    loaded_travel,
)
from flatplank_control.runner.campaign.supervised import Standstill, TurnWatch
from flatplank_control.runner.conditions import PRELOAD
from flatplank_control.runner.moves import ENOUGH
from flatplank_data.campaign import CAMPAIGN_FILE, FORMAT, Run
from flatplank_data.files import write_atomic
from flatplank_data.readers import read_description
from flatplank_data.run_record import RunRecord
from flatplank_data.store import open_store
from flatplank_data.table import MeasurementTable
from flatplank_data.yaml_text import dump_yaml, load_yaml

COLUMNS = [
    "time", "plank_position", "plank_velocity", "wheel_angle", "motor_velocity", "fx", "fy", "fz",
    "loaded_radius",
]  # fmt: skip
STOOD = 0.02
"""a wheel that turned by less stood still [rad]"""
ZERO_LIMIT = 60.0
"""largest change of the hub's zero over a run [N]"""


def read_samples(path: Path) -> MeasurementTable:
    """Samples of a bag or a table from the motion trigger on."""
    return Run(RunRecord(file=path.name), open_store(path.parent)).table(COLUMNS)


def outcome_of(
    path: Path,
    job: Job,
    limits: Limits,
    before: Standstill,
    after: Standstill,
    turn: TurnWatch | None = None,
) -> Outcome:
    """Outcome of a run: verdict, effective rolling radius of a free-rolling run, zeros."""
    table = read_samples(path)
    record = read_description(open_store(path.parent), path.name)
    enough = ENOUGH in str(record.get("stop_reason", ""))
    changed = (record.get("parameters") or {}).get(FREE, {})  # parameters other than the default
    reference = changed.get("reference", FreeRollingParameters.reference)
    verdict = judge_run(table.columns, job.measurement, limits, job.earlier, enough, reference)
    facts: dict[str, Any] = {
        "profile": force_profile(table.columns), "travel": round(loaded_travel(table.columns), 3),
    }  # fmt: skip
    zeros: list[Finding] = []
    if before.fx and after.fx:
        change = max(abs(b - a) for b, a in zip(before.zero, after.zero, strict=True))
        # without the filter the zero varies with the wheel angle, because of the shaft preload
        turned = float(abs(table.columns["wheel_angle"][-1] - table.columns["wheel_angle"][0]))
        hidden = 0.0 if after.filter_on or turned < STOOD else PRELOAD
        zeros = [Finding("zero_change", change, ZERO_LIMIT + hidden)]
        facts |= {"before": before.facts(), "after": after.facts(), FILTER_ON: after.filter_on}
    if turn is not None and turn.left == turn.left:
        facts["once_per_turn_unloaded"] = round(turn.left, 1)
        if turn.filter_on and (warning := mounting_warning(turn.left)):
            facts["warnings"] = [warning]
    evaluate = EVALUATIONS.get(job.measurement.measurement)
    if evaluate is not None:
        found_values = evaluate(table.columns, job.measurement)
        facts |= {name: float(f"{value:.6g}") for name, value in found_values.items()}
    if job.measurement.measurement == "free_rolling":
        found = radius_of_run(table)
        facts |= {"radius": found.radius, "radius_force": found.force}
    return Outcome(path.name, replace(verdict, findings=(*verdict.findings, *zeros)), facts)


def outcome_of_stopped(path: Path | None, job: Job, why: str) -> Outcome:
    """Outcome of a run in which the bench stopped; path: what was recorded of it."""
    travel = 0.0 if path is None else loaded_travel(read_samples(path).columns)
    name = job.measurement.name if path is None else path.name
    return Outcome(name, Verdict((), stopped=why), {"travel": round(travel, 3)})


def write_kept_runs(conductor: Conductor, folder: Path) -> None:
    """Write the kept runs of the journal to campaign.yaml; called again after a crash between the
    two."""
    kept = conductor.kept()
    valid = {done.valid_file for done in kept}
    others = {file for done in conductor.journal.done.values() for file in done.files} - valid
    if kept or (folder / CAMPAIGN_FILE).exists():
        write_tire(folder, conductor.plan.tire.record)
        runs = [(done.record, done.valid_file) for done in kept if done.record]
        write_campaign(folder, conductor.plan.tire.name, runs, others)


def write_tire(folder: Path, record: TireRecord) -> None:
    """Write the record of the mounted tire beside the runs, unless one exists."""
    path = folder / RECORD
    if not path.exists():
        write_atomic(path, record.to_yaml())


def write_campaign(
    folder: Path,
    tire: str,
    runs: Sequence[tuple[Mapping[str, Any], str]],
    others: Collection[str] = (),
) -> None:
    """Add records and files of runs to the folder's campaign.yaml, and remove `others`."""
    path = folder / CAMPAIGN_FILE
    old = load_yaml(path.read_bytes(), path) if path.exists() else {}
    names = {file for _, file in runs}.union(others)
    kept = [run for run in old.get("runs", []) if run["file"] not in names]
    new = [_entry(record, file) for record, file in runs]
    content = {"format": FORMAT, "tire": tire, "runs": [*kept, *new]}
    write_atomic(path, dump_yaml(content))


def _entry(record: Mapping[str, Any], file: str) -> dict:
    given = {k: v for k, v in record.items() if v not in (None, "", {}) and k != "name"}
    return {"file": file, **given}
