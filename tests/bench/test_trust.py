# SPDX-License-Identifier: Apache-2.0
"""Faults on the twin: none leaves the wheel turning uncommanded. The table that counts them."""

from __future__ import annotations

import itertools
import json

import pytest

from flatplank_control.runner.plans import PLANS
from flatplank_hw.drive import AxisDrive, safety
from flatplank_hw.drive.following import Following
from flatplank_validation.trust import registry, scenario
from flatplank_validation.trust.faults import CLOCK, FAULTS
from flatplank_validation.trust.page import ranges, table
from flatplank_validation.trust.registry import Options, Result, Tally, rows
from flatplank_validation.trust.rows import work
from flatplank_validation.trust.rows.twin import APART, pairs, triples
from flatplank_validation.trust.scenario import MOTIONS, Scenario, failure
from flatplank_validation.verbs.bench_trust import FORMAT, main

WORST = ("reference Inf", "reference 1e308", "drive deaf to set-points", "drive deaf")
"""faults that once left the wheel turning"""
TWOS = list(itertools.combinations(WORST, 2))


@pytest.mark.parametrize(("first", "second"), TWOS)
def test_two_of_the_worst_faults_do_not_leave_the_wheel_turning(first, second):
    assert not failure(Scenario("slip", ((first, 5), (second, APART))))


def test_a_deaf_drive_that_is_told_to_stand_is_stopped():
    for fault in ("drive deaf to set-points", "drive deaf"):
        assert not failure(Scenario("hanging", ((fault, 5), ("told to stand", 5))))


@pytest.mark.parametrize(
    ("motion", "faults"),
    [("free rolling", (("drive deaf", 6), ("image frozen", 19), ("reset and enabled", 14))),
     ("hanging", (("drive deaf", 114), ("told to stand", 93), ("image frozen", 116)))],
)  # fmt: skip
def test_a_frozen_image_does_not_hide_a_deaf_drive(motion, faults):
    assert not failure(Scenario(motion, faults))


def test_a_wheel_that_recovers_lost_travel_is_commanded_and_a_deaf_one_is_noticed_afterwards():
    """Enabled on the moving plank it turned with slip 0.5 for a second, as its source wants."""
    late = (("disabled", 39), ("reset and enabled", 122))
    assert not failure(Scenario("slip", (*late, ("drive deaf to set-points", 89))))
    assert not failure(Scenario("slip", late))


def test_a_disabled_wheel_that_trembles_in_the_play_of_its_gear_rests():
    """Its speed comes in samples, most of which have one sign; its angle stays."""
    faults = (("bridge frozen", 98), ("bridge NaN", 33), ("emergency stop", 9))
    assert not failure(Scenario("free rolling", faults))


@pytest.mark.parametrize(
    "faults",
    [(("plank slow", 87), ("bridge frozen", 52), ("plank encoder jumps", 80)),
     (("wheel encoder frozen", 89), ("bridge frozen", 36), ("told to stand", 29))],
)  # fmt: skip
def test_a_force_that_stays_does_not_speed_a_free_rolling_wheel_up(faults):
    """It did so within seconds: to 4 times the speed of rolling, and backward."""
    assert not failure(Scenario("free rolling", faults))


def test_a_wheel_that_is_told_to_stand_brakes_as_commanded():
    faults = (("told to stand", 22), ("drive deaf", 27), ("drive image frozen", 63))
    assert not failure(Scenario("hanging", faults))


def test_a_drive_that_becomes_deaf_while_it_brakes_does_not_creep_on():
    faults = (("told to stand", 103), ("drive deaf to set-points", 43), ("reference 1e308", 106))
    assert not failure(Scenario("hanging", faults))


def test_a_wheel_that_turns_on_before_the_last_fault_is_a_failure(monkeypatch):
    monkeypatch.setattr(Following, "update", lambda *_: None)
    faults = (("drive deaf to set-points", 5), ("told to stand", 5), ("disabled", 310))
    assert "0.100 rad/s" in failure(Scenario("hanging", faults))


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("fault", ["reference Inf", "drive deaf to set-points", "bridge NaN"])
def test_a_fault_in_every_motion(motion, fault):
    assert not failure(Scenario(motion, ((fault, 5), ("plank stops", 5))))


def test_drawn_scenarios():
    for case in triples(10, seed=20261128):
        assert not failure(case)


def test_without_its_guards_the_wheel_turns_on(monkeypatch):
    """The judge sees what it is made for: with the gate and the following error taken out, an
    infinite reference and a deaf drive are failures."""
    monkeypatch.setattr(AxisDrive, "_take", _take_all)
    monkeypatch.setattr(Following, "update", lambda *_: None)
    assert "stop reason 0" in failure(Scenario("slip", (("reference 1e308", 5),)))
    deaf = ("drive deaf to set-points", 5)
    assert not failure(Scenario("hanging", (deaf, ("disabled", 5))))  # its state machine obeys
    assert "0.100 rad/s" in failure(Scenario("hanging", (deaf, ("told to stand", 5))))


def _take_all(drive, reference):
    """The gate as it once was: a reference is cut to the limit."""
    most = drive._mode.limit.high
    drive._reference = reference._replace(value=min(max(reference.value, -most), most))


def test_every_pair_and_every_fault_is_asked():
    cases = pairs("slip")
    assert len(FAULTS) >= 22
    assert len(cases) == len(FAULTS) * (len(FAULTS) - 1) // 2
    assert {name for case in cases for name, _ in case.faults} == set(FAULTS)
    assert triples(5, 1) == triples(5, 1) != triples(5, 2)


def test_the_table_has_every_row_and_counts(monkeypatch, capsys):
    found = {name: Result(Tally(10, ["a", "b"]), 1.5, 0.05, (3,), "here") for name in rows()}
    lines = table(found)
    assert len(lines) == 2 + len(rows())
    assert all("| 10 | 5 %, seed 3 | 2 | 2 s | here |" in line for line in lines[2:])
    found["large"].tally.notes.append("1 GB in 2 s")
    assert table(found)[-2:] == ["", "- `large`: 1 GB in 2 s"]
    monkeypatch.setattr(
        scenario, "failure", lambda case: "" if case.motion != "hanging" else "bad"
    )
    assert main(["--only", "single", "--jobs", "1"]) == 1
    out = capsys.readouterr()
    assert f"| {3 * len(FAULTS)} | 1 %, seed 1 | {len(FAULTS)} |" in out.out
    assert out.err.count("single: bad") == len(FAULTS)


@pytest.mark.parametrize(
    ("seeds", "text"),
    [((7,), "7"), ((5, 4), "4, 5"), ((3, 101, 5, 4), "3 to 5, 101"),
     ((9, 1, 2, 8, 7), "1, 2, 7 to 9")],
)  # fmt: skip
def test_seeds_that_follow_each_other_are_a_range(seeds, text):
    assert ranges(seeds) == text


def test_results_of_earlier_runs_are_put_together(tmp_path, capsys):
    parts = {
        "a": ("triples", 7, [], 1), "b": ("pairs", 3, ["bad"], 1),
        "c": ("triples", 5, [], 2), "d": ("triples", 4, [], 2),
    }  # fmt: skip
    for file, (name, many, failures, seed) in parts.items():
        row = {"many": many, "failures": failures, "seconds": 2.0, "share": 0.25, "on": "here"}
        row |= {"seeds": [seed], "notes": []}
        text = json.dumps({"format": FORMAT, "rows": {name: row}})
        (tmp_path / file).write_text(text)
    files = [str(tmp_path / file) for file in parts]
    assert main(["--from", *files, "--write", str(tmp_path / "page.md")]) == 1
    lines = [line for line in (tmp_path / "page.md").read_text().splitlines() if "seed 1" in line]
    assert [line.split("|")[3:6] for line in lines] == [
        [" 3 ", " 25 %, seed 1 ", " 1 "], [" 11 ", " 50 %, seed 1, 2 ", " 0 "]
    ]  # fmt: skip
    assert "pairs: bad" in capsys.readouterr().err
    missing = set(rows()) - {"pairs", "triples"}
    (line,) = [n for n in (tmp_path / "page.md").read_text().splitlines() if "Not measured" in n]
    assert all(f"`{name}`:" in line for name in missing) and "`pairs`:" not in line
    faults = [{"area": "hub", "killed": killed} for killed in ("a test", "", "too slow")]
    (tmp_path / "journal").write_text("\n".join(json.dumps(fault) for fault in faults))
    words = ["--from", files[0], "--mutants", str(tmp_path / "journal")]
    assert main([*words, "--write", str(tmp_path / "page.md")]) == 0
    assert "| hub | 3 | 2 | 67 % |" in (tmp_path / "page.md").read_text()
    (tmp_path / "a").write_text("{}")
    with pytest.raises(SystemExit, match="a: 'format'; give an output of --json"):
        main(["--from", files[0]])


@pytest.mark.parametrize("jump", CLOCK)
def test_a_clock_that_jumps_leaves_no_wheel_turning(jump):
    assert not failure(Scenario("slip", ((jump, 5), ("plank stops", 5))))
    assert not failure(Scenario("free rolling", ((jump, 5),)))


def test_two_rows_of_one_name_and_an_unknown_row_are_refused():
    rows()
    with pytest.raises(ValueError, match="two rows are named 'pairs'"):
        registry.row("pairs", "", "")(lambda o: Tally())
    with pytest.raises(SystemExit, match="no row 'pair'; the nearest is 'pairs'"):
        main(["--only", "pair"])


def test_a_measurement_without_a_fault_finishes_and_a_false_alarm_is_seen(monkeypatch):
    case = work.drawn(1, seed=20261128)[0]
    assert case.measurement.measurement == "slip"
    assert work.failure(case) == ""
    monkeypatch.setitem(safety.DETAILS, "following_error", lambda s, p: "")
    monkeypatch.setattr(Following, "update", lambda self, s, *_: setattr(s, "torque_off_ns", 1e10))
    assert "the drive does not follow its commands" in work.failure(case)


def test_every_kind_of_measurement_is_asked():
    cases = work.drawn(3 * len(PLANS), seed=1)
    assert {case.measurement.measurement for case in cases} == set(PLANS)
    assert {case.rate_hz for case in cases} == set(work.RATES)
    assert {case.preset for case in cases} == set(work.PRESETS)


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", ["pairs", "triples", "work"])
def test_a_tenth_of_a_night(name):
    found = rows()[name].run(Options(share=0.1, seed=7, jobs=2))
    assert found.many >= 60
    assert not found.failures
