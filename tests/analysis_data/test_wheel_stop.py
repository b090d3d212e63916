# SPDX-License-Identifier: Apache-2.0
"""A wheel that was stopped on the way, in our bags and in other tables; the filled-in load."""

from __future__ import annotations

import json
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest
from bagmaker import write_run
from steptable import RADIUS, step_table
from test_measured import controlled, folder_of

from flatplank_analysis.cli import report
from flatplank_analysis.cli import table as table_verb
from flatplank_analysis.report.analysis import analyse
from flatplank_control.recording.filled import in_words, requested_record
from flatplank_data.campaign import Campaign
from flatplank_data.errors import NothingUsableError
from flatplank_data.exporters import export_campaign
from flatplank_data.measured import measured_facts, settled
from flatplank_data.stops import wheel_stop
from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES
from flatplank_hw.troubles import TROUBLES

AT = 2.6
TORQUE = RULES["torque"].code


def stopped(columns: dict[str, np.ndarray], at: float = AT, code: int = TORQUE) -> dict:
    """The same run with a wheel that a rule stops while the plank moves on."""
    x = columns["plank_position"]
    rest = x > at
    angle = np.where(rest, columns["wheel_angle"][~rest][-1], columns["wheel_angle"])
    still = {n: np.where(rest, 0.0, columns[n]) for n in ("wheel_velocity", "motor_velocity")}
    drive = {
        "drive_state": np.where(rest, float(State.SWITCH_ON_DISABLED), 4.0),
        "stop_reason": np.where(rest, float(code), 0.0),
    }
    return (
        columns
        | {"wheel_angle": angle, "fx": np.where(rest, -3000.0, columns["fx"])}
        | (still | drive)
    )


@pytest.mark.parametrize("given", ["state", "motion", "velocity"])
def test_a_stop_is_seen_by_the_state_of_the_drive_or_by_the_wheel(given: str) -> None:
    columns = stopped(controlled(0.05))
    assert wheel_stop(controlled(0.05)) is None
    if given != "state":
        columns = {k: v for k, v in columns.items() if k not in ("drive_state", "stop_reason")}
    if given == "velocity":
        del columns["wheel_angle"]
    found = wheel_stop(columns)
    assert found is not None
    assert found.position == pytest.approx(AT, abs=0.005)
    assert found.code == (TORQUE if given == "state" else 0)


def test_a_wheel_that_begins_late_waits_or_ends_with_the_road_was_not_stopped() -> None:
    run = controlled(0.05)
    x = run["plank_position"]
    late = np.where(x < 0.05, 0.0, run["wheel_angle"] - np.interp(0.05, x, run["wheel_angle"]))
    velocity = np.where(x < 0.05, 0.0, run["wheel_velocity"])
    assert wheel_stop(run | {"wheel_angle": late, "wheel_velocity": velocity}) is None
    standing = np.arange(len(x)) < 100
    before = np.where(standing, 3.0, 4.0)
    plank = np.where(standing, 0.0, x - x[100])
    assert wheel_stop(run | {"drive_state": before, "plank_position": plank}) is None
    never = run | {"drive_state": np.full(len(x), 1.0)}
    assert wheel_stop(never) is None, "flexplates off: the drive was never on"
    assert wheel_stop(run | {"drive_state": np.where(x > 4.2, 1.0, 4.0)}) is None


def test_a_wheel_over_a_standing_plank_is_not_stopped_on_the_road() -> None:
    """The plank's encoder shows a step now and then while the plank stands."""
    columns = stopped(controlled(0.05))
    step = 2.0 * np.pi * 0.05 / 20000.0
    rest = 0.05 + step * np.random.default_rng(1).integers(0, 2, columns["time"].size)
    assert wheel_stop(columns | {"plank_position": rest}) is None


def test_a_run_that_nobody_described_is_recorded_as_stopped(tmp_path: Path) -> None:
    said = requested_record("")
    write_run(tmp_path / "bag", stopped(controlled(0.05)), said.record.to_yaml(), "bag")
    record = said.filled_in(said.record, tmp_path / "bag")
    assert record.status == "stopped"
    assert record.stop_reason == f"the wheel was stopped at 2.60 m: {TROUBLES['torque'].text}"
    assert (record.kappa, record.fz, record.effective_rolling_radius) == (0.05, 3700.0, RADIUS)
    assert "slip +5 %, from 1.5 m" in in_words(record.with_changes(cycles_received=9))


def test_a_described_run_is_recorded_as_stopped_and_keeps_its_keys(tmp_path: Path) -> None:
    said = requested_record("{tire: TOY, measurement: slip, kappa: 0.05, fz: 3000.0}", "bag")
    write_run(tmp_path / "bag", stopped(controlled(0.05)), said.record.to_yaml(), "bag")
    record = said.filled_in(said.record, tmp_path / "bag")
    assert (record.status, record.fz, record.filled_in) == ("stopped", 3000.0, [])


def test_a_bag_that_calls_itself_complete_is_evaluated_up_to_the_stop(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = (
        f"tire: TOY\nkappa: 0.05\nfz: 3700.0\npressure: 2.5\nstep_position: 1.5\n"
        f"effective_rolling_radius: {RADIUS}\n"
    )
    folder = folder_of(tmp_path, stopped(controlled(0.05)), record)
    assert report.main([str(folder), "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    told = [line for line in out["problems"] if "the wheel was stopped at 2.60 m" in line]
    assert len(told) == 1 and TROUBLES["torque"].text in told[0]
    found = json.loads(Path(out["data"]).read_text())
    (radius,) = found["radii"]
    assert radius["radius"] == pytest.approx(RADIUS, rel=1e-4)
    assert found["points"][0]["conditions"][0]["facts"]["kappa_actual"] == pytest.approx(
        0.05, abs=2e-4
    )


def test_a_run_that_ended_as_stopped_is_told_by_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = requested_record("{tire: TOY, name: bad}")
    for name, columns in (("bad", stopped(controlled(0.05))), ("good", controlled(0.05))):
        write_run(tmp_path / name, columns, said.record.to_yaml(), name)
        record = said.filled_in(said.record, tmp_path / name).with_changes(name=name)
        record = record if record.status == "stopped" else record.with_changes(status="complete")
        record.with_changes(uuid=str(uuid4())).save(tmp_path / name)
    assert table_verb.main([str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "1 runs" in out
    assert "bad: left out: it ended as 'stopped' (the wheel was stopped at 2.60 m" in out + err


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_table_from_elsewhere_ends_at_the_stop(tmp_path: Path, suffix: str) -> None:
    table = step_table(0.05)
    columns = stopped(dict(table.columns))
    named = {k: v for k, v in columns.items() if k not in ("drive_state", "stop_reason")}
    folder = export_campaign([table.with_columns(**named)], tmp_path / "c", suffix)
    campaign = Campaign.load(folder)
    (read,) = campaign.tables(("plank_position", "fx"))
    assert set(read.columns) == {"plank_position", "fx"}
    assert read["plank_position"][-1] == pytest.approx(AT, abs=0.01)
    assert read["fx"].min() > -100.0
    (told,) = [p for p in campaign.problems if "stopped" in p.what]
    assert "left out" in told.remedy and not told.fatal


def test_a_wheel_stopped_before_its_step_gives_no_run(tmp_path: Path) -> None:
    table = step_table(0.05)
    columns = stopped(dict(table.columns), 1.2)
    named = {k: v for k, v in columns.items() if k not in ("drive_state", "stop_reason")}
    folder = export_campaign([table.with_columns(**named)], tmp_path / "c", ".csv")
    assert list(Campaign.load(folder).tables()) == []
    with pytest.raises(NothingUsableError, match="before the step"):
        analyse(Campaign.load(folder))


@pytest.mark.parametrize("until", [0.2, 0.6, 1.1])
def test_the_filled_in_load_is_that_which_was_reached(until: float) -> None:
    """The axle still comes down while the plank moves; the step is at 1.5 m."""
    run = controlled(0.05)
    x = run["plank_position"]
    noise = 30.0 * np.random.default_rng(2).normal(size=len(x))
    rising = 3699.5 * np.minimum((x + 0.1) / (until + 0.1), 1.0)
    turning = 20.0 * np.sin(run["wheel_angle"])
    facts = measured_facts(run | {"fz": rising + noise + turning})
    assert facts["fz"] == 3700.0 and "notes" not in facts
    assert np.mean(rising[x < 1.5]) < 3690.0


def test_a_load_that_never_settles_is_noted(tmp_path: Path) -> None:
    run = controlled(0.05)
    x = run["plank_position"]
    facts = measured_facts(run | {"fz": 3000.0 + 500.0 * x})
    assert facts["notes"].startswith("fz is not constant: it changes by +")
    assert "notes" not in measured_facts(run | {"fz": 3700.0 + 40.0 * np.sin(6.0 * x)})
    said = requested_record("")
    write_run(tmp_path / "bag", run | {"fz": 3000.0 + 500.0 * x}, said.record.to_yaml(), "bag")
    assert "fz is not constant" in said.filled_in(said.record, tmp_path / "bag").notes


def test_the_settled_part_is_the_end() -> None:
    signal = np.concatenate([np.linspace(0.0, 10.0, 300), np.full(700, 10.0)])
    assert settled(signal, 0.1) == (10.0, 0.0)
    assert settled(np.array([3.0]), 0.1) == (3.0, 0.0)
    value, change = settled(np.linspace(0.0, 10.0, 1000), 0.1)
    assert value > 7.0 and change > 1.0
