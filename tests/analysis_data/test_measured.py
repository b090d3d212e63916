# SPDX-License-Identifier: Apache-2.0
"""Records that nobody filled in, and records that say something else than what was measured."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from bagmaker import write_run
from steptable import RADIUS, step_table

from flatplank_analysis.cli import report
from flatplank_analysis.report.analysis import analyse
from flatplank_control.recording.filled import in_words, requested_record
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.exporters import export_campaign
from flatplank_data.measured import measured_facts, with_values_in_use

SILENT = "tire: X\nname: mine\nmeasurement: slip\nkappa: 0.0\nfz: 0.0\npressure: 0.0\nstart: 1\n"
"""what a recorder wrote that was told nothing"""
SAID = (
    "tire: TOY\nkappa: {kappa}\nfz: 3700.0\npressure: 2.5\nstep_position: {step}\n"
    "effective_rolling_radius: {radius}\n"
)


def controlled(kappa: float, start: int = 1, **changes) -> dict[str, np.ndarray]:
    """Columns of a run under slip control, as its nodes said them."""
    run = step_table(kappa, start)
    x = run["plank_position"]
    return dict(run.columns) | {
        "wheel_angle": run["wheel_angle"] + 2.0 * np.pi / 3.0 * (start - 1),
        "fz": run["fz"] + 7.0,
        "slip_reference": np.where(x > 1.5, kappa, 0.0),
        "slip_start": np.full(len(x), 1.5),
        "slip_radius": np.full(len(x), RADIUS),
        **changes,
    }


def folder_of(tmp_path: Path, columns: dict[str, np.ndarray], record: str) -> Path:
    """A data folder with one bag and its record, as the recorder leaves them."""
    write_run(tmp_path / "mine", columns, record, "mine")
    (tmp_path / "mine" / "run.yaml").write_text(record + "status: complete\n")
    return tmp_path


def test_the_samples_say_what_a_run_was():
    facts = measured_facts(controlled(0.05, 3))
    assert facts == {
        "direction": "forward",
        "speed": 0.031,
        "measurement": "slip",
        "effective_rolling_radius": RADIUS,
        "step_position": 1.5,
        "kappa": 0.05,
        "waveform": {"name": "step", "kappa": 0.05},
        "fz": 3700.0,
        "start": 3,
    }


def test_what_the_samples_do_not_say_is_left_open():
    run = step_table(0.0)
    rolled = dict(run.columns) | {"controller_error": np.zeros(len(run))}
    assert measured_facts(rolled)["measurement"] == "free_rolling"
    assert measured_facts(dict(run.columns))["measurement"] == "unknown"
    asked = 0.02 * np.sin(run["plank_position"])
    wave = controlled(0.02, slip_reference=asked)
    assert measured_facts(wave)["waveform"] == {"name": "varying"}
    assert "kappa" not in measured_facts(wave)
    sine = {"amplitude": 0.02, "wavelength": 6.283, "offset": 0.0}
    was_set = [
        {"name": "sine", "start_position": 1.5, "parameters": sine},
        {"name": "triangle", "start_position": 0.9, "parameters": {}},
    ]
    assert measured_facts(wave, waveforms=was_set)["waveform"] == {"name": "sine", **sine}
    assert measured_facts(wave, waveforms=was_set[1:])["waveform"] == {"name": "varying"}
    short = {k: v[:400] for k, v in controlled(0.05).items()}  # ended before the step
    assert not {"kappa", "waveform"} & measured_facts(short).keys()
    standing = dict(run.columns) | {"plank_position": np.zeros(len(run))}
    assert measured_facts(standing) == {"measurement": "unknown"}


def test_a_report_of_a_run_that_nobody_described_is_right(tmp_path, capsys):
    """By services alone: slip 5 % from 1.5 m, rolling radius and load as the nodes had them."""
    folder = folder_of(tmp_path, controlled(0.05, 2), SILENT.replace("tire: X", "tire: unknown"))
    assert report.main([str(folder), "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    (told,) = out["problems"]
    assert told.startswith(
        "mine: tire and pressure unknown: not stated; write tire: and pressure:"
    )
    found = json.loads(Path(out["data"]).read_text())
    (point,) = found["points"]
    (condition,) = point["conditions"]
    assert condition["condition"]["kappa"] == 0.05 and condition["condition"]["fz"] == 3700.0
    assert condition["condition"]["tire"] == "unknown"
    assert condition["condition"]["pressure"] is None
    assert condition["facts"]["kappa_actual"] == pytest.approx(0.05, abs=2e-4)
    (radius,) = found["radii"]
    assert radius["radius"] == pytest.approx(RADIUS, rel=1e-4)
    assert radius["start"] == 2


def test_free_rolling_and_repeats_that_nobody_described_find_their_conditions(tmp_path):
    rolled = step_table(0.0)
    runs = {
        "a": controlled(0.05),
        "b": controlled(0.05, 2, fz=rolled["fz"] - 11.0),
        "c": dict(rolled.columns) | {"controller_error": np.zeros(len(rolled))},
    }
    for name, columns in runs.items():
        write_run(tmp_path / name, columns, SILENT, name)
        (tmp_path / name / "run.yaml").write_text(SILENT + "status: complete\n")
    found = {c.measurement: len(runs) for c, runs in Campaign.load(tmp_path).conditions().items()}
    assert found == {"slip": 2, "free_rolling": 1}


@pytest.mark.parametrize(
    ("said", "measured", "words"),
    [
        ({"kappa": 0.0}, 0.05, r"\+0 % stated, but \+5 % was asked for"),
        ({"kappa": -0.05}, 0.05, r"-5 % stated, but \+5 % was asked for"),
        ({"kappa": 0.05}, 0.02, r"\+5 % stated, but \+2 % was asked for"),
    ],
)
def test_a_record_with_another_slip_than_the_one_measured_is_refused(
    tmp_path, said, measured, words
):
    record = SAID.format(step=1.5, radius=RADIUS, **said)
    folder = folder_of(tmp_path, controlled(measured), record)
    (run,) = Campaign.load(folder).runs
    with pytest.raises(FlatplankError, match=words):
        run.table()
    with pytest.raises(NothingUsableError, match=words):
        analyse(Campaign.load(folder))


def test_the_radius_and_the_step_in_use_go_over_those_that_were_said(tmp_path):
    folder = folder_of(tmp_path, controlled(0.05), SAID.format(kappa=0.05, step=1.2, radius=0.3))
    campaign = Campaign.load(folder)
    (table,) = campaign.tables()
    assert table.info.effective_rolling_radius == RADIUS and table.info.step_position == 1.5
    told = [str(p) for p in campaign.problems]
    assert any("300 mm stated, 310 mm was in use and is used" in line for line in told)
    assert any("1.2 m stated, 1.5 m was in use and is used" in line for line in told)


def test_free_rolling_is_no_slip_run_and_a_wave_is_no_step(tmp_path):
    info = Campaign.load(
        folder_of(tmp_path, controlled(0.05), SAID.format(kappa=0.05, step=1.5, radius=RADIUS))
    ).infos[0]
    for measured, words in (
        ({"measurement": "free_rolling"}, "slip stated, but free_rolling was on"),
        ({"measurement": "slip", "waveform": {"name": "varying"}}, "was not constant"),
        ({"measurement": "slip", "waveform": {"name": "sine"}}, "was not constant"),
    ):
        (problem,) = with_values_in_use(info, measured)[1]
        assert problem.fatal and words in str(problem)
    assert with_values_in_use(info, {"measurement": "unknown"}) == (info, [])


@pytest.mark.parametrize("kappa", [0.05, -0.03])
def test_a_table_without_a_slip_control_shows_its_step_too(tmp_path, kappa):
    """Nothing said of a step, and the wheel gets faster by 5 % on the way."""
    folder = export_campaign([step_table(kappa)], tmp_path / "campaign", ".csv")
    path = folder / "campaign.yaml"
    content = yaml.safe_load(path.read_text())
    entry = content["runs"][0]
    for key in ("step_position", "effective_rolling_radius"):
        del entry[key]
    entry["kappa"] = 0.0
    path.write_text(yaml.safe_dump(content))
    words = f"no step is stated, but the slip changes by {100 * kappa:+.1f} %"
    with pytest.raises(FlatplankError, match=re.escape(words)):
        Campaign.load(folder).runs[0].table()


def test_a_record_of_no_slip_and_a_wheel_with_5_percent_is_refused(tmp_path):
    folder = export_campaign([step_table(0.05)], tmp_path / "campaign", ".csv")
    path = folder / "campaign.yaml"
    path.write_text(path.read_text().replace("kappa: 0.05", "kappa: 0.0"))
    with pytest.raises(FlatplankError, match=r"desired slip \+0, measured \+0.05"):
        Campaign.load(folder).runs[0].table()


def recorded(tmp_path, columns: dict[str, np.ndarray], text: str, name: str = ""):
    """The record as a recorder closes it that was given a text, and what it tells people."""
    said = requested_record(text, name)
    write_run(tmp_path / "bag", columns, said.record.to_yaml(), "bag")
    record = said.filled_in(said.record, tmp_path / "bag")
    return record, in_words(record.with_changes(cycles_received=90, cycles_lost=10))


def test_the_recorder_fills_in_what_nobody_said(tmp_path):
    record, words = recorded(tmp_path, controlled(0.05, 2), "")
    assert (record.name, record.tire, record.kappa, record.fz) == (
        "by_hand",
        "unknown",
        0.05,
        3700,
    )
    assert (record.step_position, record.effective_rolling_radius) == (1.5, RADIUS)
    assert (record.start, record.measurement, record.notes) == (2, "slip", "")
    assert {"kappa", "fz", "effective_rolling_radius"} <= set(record.filled_in)
    assert words == (
        "slip +5 %, from 1.5 m, r_e 310.0 mm, Fz 3700 N, tire unknown, pressure not given, "
        "10 of 100 cycles lost"
    )


def test_a_recording_that_never_began_says_so():
    said = in_words(requested_record("{tire: TOY}").record)
    assert said.startswith("nothing was recorded: the plank did not start to move")


def test_what_was_said_stays_and_what_was_measured_otherwise_is_noted(tmp_path):
    record, _ = recorded(tmp_path, controlled(0.05), "{tire: TOY, kappa: 0.0, pressure: 2.5}")
    assert (record.name, record.kappa, record.fz) == ("TOY_by_hand", 0.0, 3700.0)
    assert "kappa" not in record.filled_in
    assert record.notes == "+0 % stated, but +5 % was asked for"


def test_a_whole_record_needs_no_bag_and_a_bag_without_samples_is_noted(tmp_path):
    assert requested_record(
        "{tire: TOY, measurement: slip, kappa: 0.02, fz: 3000.0}", "mine"
    ).has_essential_keys
    assert not requested_record("{tire: TOY, kappa: 0.02}").has_essential_keys
    nothing = {name: values[:0] for name, values in controlled(0.05).items()}
    said = requested_record("")
    write_run(tmp_path / "empty", nothing, "", "empty")
    record = said.filled_in(said.record, tmp_path / "empty")
    assert record.notes.startswith("not filled in: empty: no message on /encoders/state")
