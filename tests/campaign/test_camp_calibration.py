# SPDX-License-Identifier: Apache-2.0
"""Calibrations recover what was put in, say how good they are, and when they no longer hold."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.book import CalibrationBook, Entry
from flatplank_control.calibration.fits import fit_line, mounting_warning
from flatplank_control.calibration.friction import friction_of
from flatplank_control.calibration.parasitic import amplitudes_per_turn
from flatplank_control.calibration.sheet import LINES, empty_sheet, starting_values
from flatplank_control.cli.calibrate import main
from flatplank_control.cli.tune import main as tune
from flatplank_control.runner.campaign.supervised import Standstill, TurnWatch, supervised
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.machine import FRICTION_SPEED, FRICTION_TORQUE, GEAR_RATIO
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_hw.hub.identify import identify_fit
from flatplank_hw.hub.params import HubParameters
from flatplank_hw.hub.parasitic import fit_to_text
from flatplank_sim.simulator import filter_on_twin, turn_on_twin
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench


def test_a_line_with_its_errors():
    random = np.random.default_rng(4)
    x = np.linspace(0.0, 5000.0, 11)
    line = fit_line(list(zip(x, 3.0 + 1.02 * x + random.normal(0.0, 5.0, 11), strict=True)))
    assert abs(line.slope - 1.02) < 4.0 * line.slope_error
    assert abs(line.offset - 3.0) < 4.0 * line.offset_error
    assert 1.0 < line.residual < 10.0


def test_two_points_leave_the_uncertainty_of_the_reading():
    assert fit_line([(0.0, 0.0), (2.0, 4.0)], reading=0.1).slope_error > 0.05
    with pytest.raises(ValueError, match="at least two different points"):
        fit_line([(1.0, 2.0), (1.0, 2.1)])


def test_what_is_expired_or_absent_is_said(tmp_path):
    book = CalibrationBook(tmp_path / "c.yaml")
    book.add(Entry("hub_fx", "2020-01-01", {"k_fx1": 3.6}, 0.4))
    book.add(Entry("lvdt", "2026-01-01", {"lvdt_gain": 0.021}, 0.0))
    bench = BenchSetup(calibration=str(tmp_path / "c.yaml"))
    record = CalibrationBook(tmp_path / "c.yaml").record(date(2026, 2, 1), bench.constants())
    assert record["hub_fx"]["status"].startswith("expired: of 2020-01-01")
    assert record["lvdt"]["status"] == "valid: of 2026-01-01"
    assert record["motor"] == {"status": "absent", "gear_ratio": 1425.04}


def test_a_run_record_states_what_the_nodes_have(tmp_path):
    """A bench that was started without the book has other constants: the record says so."""
    book = CalibrationBook(tmp_path / "c.yaml")
    book.add(Entry("lvdt", "2026-01-01", {"lvdt_gain": 0.021, "lvdt_offset": 0.31}, 0.0))
    without = book.record(date(2026, 2, 1), BenchSetup().constants())["lvdt"]
    assert without["status"] == "not in force: of 2026-01-01; start the bench again"
    assert (without["lvdt_gain"], without["lvdt_offset"]) == (0.02, 0.3)
    given = BenchSetup(calibration=str(book.path))
    assert book.record(date(2026, 2, 1), given.constants())["lvdt"]["lvdt_gain"] == 0.021


def test_the_twin_measures_with_the_book_and_the_rim_of_its_plan(tmp_path):
    book = CalibrationBook(tmp_path / "c.yaml")
    book.add(Entry("hub_fz", "2026-01-01", {"k_fz1": 2.0, "k_fz2": 1.95}, 0.0))
    book.add(Entry("motor", "2026-01-01", {"gear_ratio": 1425.5}, 0.0))
    twin = Twin(BenchSetup(pace="hold", calibration=str(book.path)))
    assert (twin.hub.parameters.k_fz1, twin.hub.parameters.k_fx1) == (2.0, 3.5841)
    assert twin.encoders.parameters.gear_ratio == twin.drive.parameters.gear_ratio == 1425.5
    bench = TwinBench(twin, TableLog(tmp_path))
    m = Measurement(measurement="stiffness_longitudinal", et_value=0.055)
    bench.perform(plan_of(m))
    assert twin.hub.parameters.et_value == 0.055
    info = Campaign.load(tmp_path).infos[0]
    assert (info.et_value, info.adapter_thickness) == (0.055, 0.02)
    with pytest.raises(ValueError, match="et_value is 0.5 m, must be within"):
        replace(m, et_value=0.5)


def test_the_command_calibrates_the_hub_and_tells_the_status(tmp_path, capsys):
    book = ["--book", str(tmp_path / "c.yaml"), "--date", "2026-05-01"]
    pairs = "0:2,1000:1012,4000:4042"
    assert main([*book, "hub", "--axis", "fz", "--pairs", pairs]) == 0
    assert CalibrationBook(tmp_path / "c.yaml").entries["hub_fz"].parameters[
        "k_fz1"
    ] == pytest.approx(1.9775 * 1.01, rel=1e-3)
    assert main([*book, "status"]) == 1
    assert "motor          absent" in capsys.readouterr().out


def test_each_axis_of_the_hub_keeps_its_own_date(tmp_path):
    path = tmp_path / "c.yaml"
    for axis, day, read in (("fz", "2026-05-01", 1010.0), ("fx", "2026-05-02", 990.0)):
        what = ["--book", str(path), "--date", day, "hub", "--axis", axis]
        assert main([*what, "--pairs", f"0:0,1000:{read}"]) == 0
    found = CalibrationBook(path)
    assert {n: e.date for n, e in found.entries.items()} == {
        "hub_fz": "2026-05-01", "hub_fx": "2026-05-02",
    }  # fmt: skip
    assert found.parameters()["measurement_hub"] == pytest.approx(
        {"k_fz1": 1.9775 * 1.01, "k_fz2": 1.9396 * 1.01, "k_fx1": 3.5841 * 0.99,
         "k_fx2": 3.8158 * 0.99}
    )  # fmt: skip


@pytest.mark.parametrize(
    ("what", "instrument", "name", "first"),
    [
        (["hub", "--axis", "fy"], "hub_fy", "k_fy", 3.8246),
        (["plank"], "plank_encoder", "pinion_pitch_radius", 0.05),
        (["motor"], "motor", "gear_ratio", 1425.04),
    ],
)
def test_a_second_calibration_goes_on_from_the_first(tmp_path, what, instrument, name, first):
    """On the corrected bench the readings are right: the constant stays as it is."""
    command = ["--book", str(tmp_path / "c.yaml"), *what, "--pairs"]
    assert main([*command, "0:0,1000:1010"]) == 0
    corrected = CalibrationBook(tmp_path / "c.yaml").entries[instrument].parameters[name]
    assert corrected != pytest.approx(first, rel=1e-3)
    assert main([*command, "0:0,1000:1000"]) == 0
    assert CalibrationBook(tmp_path / "c.yaml").entries[instrument].parameters[name] == corrected


def test_the_parasitic_fit_is_found_beside_its_book(tmp_path, monkeypatch):
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "parasitic_m1.yaml").touch()
    book = CalibrationBook(tmp_path / "lab" / "calibration.yaml")
    book.add(Entry("parasitic", "2026-05-01", {"parasitic_fit": "parasitic_m1.yaml"}, 3.0))
    monkeypatch.chdir(tmp_path)
    file = Path(book.parameters()["measurement_hub"]["parasitic_fit"])
    assert file == tmp_path / "lab" / "parasitic_m1.yaml"
    file.unlink()
    with pytest.raises(ValueError, match="no file .*parasitic_m1.yaml; put it back"):
        book.parameters()


HEAD = "format: flatplank-calibration/1\nentries:\n"
WRONG = {
    "yaml": (HEAD + "  hub_fx: {", "not YAML"),
    "format": ("entries: {}", "format is not flatplank-calibration/1"),
    "entries": ("format: flatplank-calibration/1\nentries: 3", "no 'entries:'"),
    "unknown": (HEAD + "  hub_fq: {date: 2026-01-01, parameters: {}, residual: 0}", "nearest"),
    "missing": (HEAD + "  motor: {date: 2026-01-01}", "motor: missing"),
    "date": (HEAD + "  motor: {date: today, parameters: {}, residual: 0}", "'today' is no date"),
    "text": (
        HEAD + "  motor: {date: 2026-01-01, parameters: {gear_ratio: x}, residual: 0}",
        "gear_ratio is 'x'; calibrate it again",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_broken_book_is_told_in_one_line(case, tmp_path):
    text, words = WRONG[case]
    (tmp_path / "c.yaml").write_text(text)
    with pytest.raises(ValueError, match=words) as told:
        CalibrationBook(tmp_path / "c.yaml")
    assert str(told.value).startswith(str(tmp_path / "c.yaml")) and "\n" not in str(told.value)


@pytest.mark.parametrize("pairs", ["0:1,1000", "0:1:2,3:4", "a:b", ""])
def test_pairs_that_are_none_are_told_in_one_line(pairs, tmp_path):
    with pytest.raises(ValueError, match="write known:read, with commas"):
        main(["--book", str(tmp_path / "c.yaml"), "plank", "--pairs", pairs])


@pytest.mark.parametrize("text", ["readings: {", "format: flatplank-preflight/1\nreadings: 3\n"])
def test_a_broken_sheet_is_told_in_one_line(text):
    with pytest.raises(
        ValueError, match=r"^sheet( line \d+)?: (not YAML|'readings' must be)"
    ) as told:
        starting_values(text, "sheet")
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    "words", [["--cx", "0"], ["--cfk", "0"], ["--cx", "200", "--rate", "0"], ["--cx", "nan"]]
)
def test_tune_refuses_what_is_not_above_zero(words):
    with pytest.raises(ValueError, match=f"{words[-2]} is (0|nan), must be above 0"):
        tune(words)


def test_friction_is_measured_and_written_where_the_hub_reads_it(tmp_path, capsys):
    """The twin's wheel, unloaded at seven speeds, needs the torque of the machine's table, and
    that of its bearing behind the gear."""
    book = ["--book", str(tmp_path / "c.yaml"), "--date", "2026-05-01"]
    assert main([*book, "friction", "--sim"]) == 0
    assert "0.75" in capsys.readouterr().out
    hub = Twin(BenchSetup(pace="hold", calibration=str(tmp_path / "c.yaml"))).hub.parameters
    assert len(hub.friction_speed) == 7 and hub.friction_speed[4] == pytest.approx(142.0, abs=0.1)
    bearing = 1.0 / 0.392 / GEAR_RATIO
    wanted = np.interp(hub.friction_speed, FRICTION_SPEED, FRICTION_TORQUE) + bearing
    assert hub.friction_torque == pytest.approx(wanted, abs=0.005)
    again = CalibrationBook(tmp_path / "c.yaml")
    bench = BenchSetup(calibration=str(again.path)).constants()
    assert again.record(date(2026, 5, 2), bench)["friction"] == {
        "status": "valid: of 2026-05-01",
        "friction_speed": list(hub.friction_speed), "friction_torque": list(hub.friction_torque),
    }  # fmt: skip


def test_friction_without_a_constant_speed_is_refused():
    time = np.arange(0.0, 4.0, 0.004)
    columns = {"time": time, "motor_velocity": 50.0 * time, "motor_torque": 0.8 + 0.0 * time}
    with pytest.raises(FlatplankError, match="never turns at a constant speed"):
        friction_of([MeasurementTable(columns, RunRecord(file="ramp"))])


@pytest.mark.parametrize("words", [[], ["--sim", "--bag", "x"]])
def test_friction_asks_for_bags_or_the_twin(words, tmp_path):
    with pytest.raises(ValueError, match="friction: give --bag of unloaded turns"):
        main(["--book", str(tmp_path / "c.yaml"), "friction", *words])


def test_the_parasitic_filter_of_one_mounting():
    """Amplitude over the third turn, which the fit has not seen: thesis 300 N before, 25 N
    after."""
    turn = turn_on_twin(BenchSetup(preset="thesis2023", pace="hold"))
    fit = identify_fit(turn.angle, turn.volts, "m1", "2026-05-01")
    p = HubParameters()
    before, after = amplitudes_per_turn(turn, None, p), amplitudes_per_turn(turn, fit, p)
    assert before["fx"] > 200.0 and before["fz"] > 200.0
    assert after["fx"] < 5.0 and after["fz"] < 5.0
    assert mounting_warning(after["fz"]) == ""
    moved = turn._replace(angle=turn.angle + 0.3)
    assert "not that of this mounting" in mounting_warning(
        amplitudes_per_turn(moved, fit, p)["fz"]
    )


def test_the_sheet_gives_starting_values_of_known_effects(tmp_path):
    from dataclasses import fields
    from importlib import import_module

    text = empty_sheet("2026-05-01").replace("road_play: null", "road_play: 1.15")
    assert starting_values(text, "sheet") == {"road_play": {"gap": pytest.approx(1.15e-3)}}
    with pytest.raises(ValueError, match="steering_zero is 50.0, must be a number within 5 deg"):
        starting_values(text.replace("steering_zero: null", "steering_zero: 50.0"), "sheet")
    registry = import_module("flatplank_analysis.effects")
    effects = {e.name: e for e in vars(registry).get("EFFECTS", {}).values()}
    for line in LINES.values():
        if line.effect in effects:
            assert line.parameter in {f.name for f in fields(effects[line.effect])}


def test_the_run_warns_when_the_fit_is_of_another_mounting(tmp_path):
    """The unloaded wheel is looked at on its way to the start of the next run."""
    setup = BenchSetup(preset="thesis2023", pace="hold")
    turn = turn_on_twin(setup)
    fit = identify_fit(turn.angle, turn.volts, "m1", "2026-01-01")
    other = identify_fit(turn.angle + 1.0, turn.volts, "m0", "2025-01-01")
    said = []
    for name, one in (("m1", fit), ("m0", other)):
        path = tmp_path / f"{name}.yaml"
        path.write_text(fit_to_text(one), encoding="utf-8")
        hub = {"parasitic_fit": str(path), "filter_on": True}
        own = replace(setup, parameters={"measurement_hub": hub})
        bench = TwinBench(Twin(own), TableLog(tmp_path / name))
        watch = TurnWatch()
        m = Measurement(measurement="stiffness_longitudinal", start=3)
        bench.perform(supervised(m, Standstill("before"), Standstill("after"), watch))
        said.append((watch.left, mounting_warning(watch.left)))
    assert said[0][1] == "" and said[0][0] < 20.0
    assert "not that of this mounting" in said[1][1] and said[1][0] > 100.0


def test_the_filter_is_judged_under_load(tmp_path):
    setup = BenchSetup(preset="thesis2023", pace="hold")
    turn = turn_on_twin(setup)
    path = tmp_path / "fit.yaml"
    path.write_text(fit_to_text(identify_fit(turn.angle, turn.volts, "m", "2026-01-01")))
    found = filter_on_twin(setup, path, 0.0, last=2.9)
    for name in ("fx", "fz"):
        plain, filtered = found[name]
        assert filtered < 0.25 * plain
