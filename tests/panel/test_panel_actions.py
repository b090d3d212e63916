# SPDX-License-Identifier: Apache-2.0
"""What an action of a page asks of the bench: word for word."""

from __future__ import annotations

import math
from typing import Any

import pytest
import yaml
from own_loop import finished
from test_panel_operator import Answers

from flatplank_data.waveforms import WAVEFORMS
from flatplank_panel.host import Host
from flatplank_panel.operator import Operator, waveform_of


@pytest.fixture
def bench(tmp_path) -> Operator:
    link: Any = Answers()
    operator = Operator(link, Host(tmp_path, tmp_path / "log"), tmp_path)
    operator.take_charge("me", "My name")
    return operator


def claims(bench: Operator) -> int:
    return sum(request == "claim" for request, _ in bench.link.asked)


CLAIMED = [
    (lambda o: o.release_emergency_stop("me"), "emergency_stop", {"data": False},
     "emergency stop released"),
    (lambda o: o.enable("me", True), "enable", {"data": True}, "enabled"),
    (lambda o: o.reset_fault("me"), "reset_fault", {}, "fault reset"),
    (lambda o: o.set_mode("me", "slip", 5.0), "mode", {"mode": "slip", "value": 0.0},
     "mode slip"),
    (lambda o: o.set_mode("me", "velocity", "0.5"), "mode", {"mode": "velocity", "value": 0.5},
     "mode velocity 0.5 rad/s"),
    (lambda o: o.set_mode("me", "torque", -2), "mode", {"mode": "torque", "value": -2.0},
     "mode torque -2 N m"),
    (lambda o: o.set_mode("me", "position", 180), "mode",
     {"mode": "position", "value": pytest.approx(math.pi)}, "mode position 180 deg"),
    (lambda o: o.move_to("me", "120"), "move_to", {"angle_deg": 120.0}, "turn to 120 deg"),
    (lambda o: o.tare("me"), "tare", {}, "zero is being taken"),
    (lambda o: o.set_filter("me", True), "filter", {"data": True}, "parasitic filter on"),
    (lambda o: o.set_filter("me", 0), "filter", {"data": False}, "parasitic filter off"),
    (lambda o: o.save_recording("me"), "stop_record", {"status": "complete", "notes": ""},
     "recording saved"),
    (lambda o: o.discard_recording("me"), "discard", {}, "recording discarded"),
    (lambda o: o.confirm_prompt("me"), "confirm", {}, "confirmed"),
    (lambda o: o.set_by_hand("me", "load_to", "3700"), "load_to", {"value": 3700.0},
     "Load 3700 N"),
    (lambda o: o.set_by_hand("me", "steer", -5), "steer", {"value": -5.0}, "Steering -5 deg"),
    (lambda o: o.unload("me"), "unload", {}, "wheel lifted"),
    (lambda o: o.move_plank("me", 1, False, "1.5"), "plank",
     {"direction": 1, "fast": False, "stop_at": 1.5}, "plank forward"),
]  # fmt: skip
FREE = [
    (lambda o: o.enable("me", False), "enable", {"data": False}, "disabled"),
    (lambda o: o.quick_stop("me"), "quick_stop", {}, "quick stop"),
]  # fmt: skip


@pytest.mark.parametrize(("act", "request_", "fields", "said"), [*CLAIMED, *FREE])
def test_what_is_asked_and_what_the_log_says(bench, act, request_, fields, said):
    assert finished(act(bench)) == said == bench.link.state.log[0][1]
    assert bench.link.done() == [(request_, fields)]
    assert claims(bench) == (said not in ("disabled", "quick stop"))
    assert len(bench.link.state.log) == 1


@pytest.mark.parametrize(
    ("direction", "stop_at", "word", "claimed"),
    [(0, None, "stop", 0), (-1, "", "reverse", 1), (1, None, "forward", 1)],
)
def test_the_plank_stops_without_a_claim_and_moves_with_one(
    bench, direction, stop_at, word, claimed
):
    assert finished(bench.move_plank("me", direction, stop_at=stop_at)) == f"plank {word}"
    ((request_, fields),) = bench.link.done()
    assert (request_, fields["direction"], fields["fast"]) == ("plank", direction, True)
    assert math.isnan(fields["stop_at"]) and claims(bench) == claimed


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda o: o.set_mode("me", "fly"), "mode 'fly' is not known"),
        (lambda o: o.set_mode("me", "velocity", 101), "velocity is 101 rad/s, must be within"),
        (lambda o: o.set_mode("me", "position", -100_001), "position is -100001 deg, must be"),
        (lambda o: o.move_to("me", 100_001), "position is 100001 deg, must be within -100000"),
        (lambda o: o.set_by_hand("me", "fly", 1), "quantity 'fly' is not known"),
        (lambda o: o.set_by_hand("me", "load_to", 8001), "fz is 8001 N, must be within"),
        (lambda o: o.move_plank("me", 1, True, -1.1), "stop position is -1.1 m, must be within"),
        (lambda o: o.move_plank("me", 1, True, 4.23), "stop position is 4.23 m, must be within"),
        (lambda o: o.load_fit("me", "../x.yaml"), "file '../x.yaml' is outside"),
        (lambda o: o.set_constants("me", {"et_value": 9.0}), "is 9 m, must be within"),
    ],
)  # fmt: skip
def test_what_is_out_of_range_is_not_asked(bench, act, said):
    with pytest.raises(ValueError) as raised:
        finished(act(bench))
    assert said in str(raised.value) and bench.link.done() == []


def test_a_waveform_is_set_and_slip_is_selected(bench):
    values = {"kappa": "0.05"} if "kappa" in vars(WAVEFORMS["step"]()) else {}
    finished(bench.set_waveform("me", "step", values, "1.5", 0.31))
    (first, about), second = bench.link.done()
    assert first == "waveform" and second == ("mode", {"mode": "slip", "value": 0.0})
    assert about == {
        "name": "step", "parameters": list(values), "values": [0.05] * len(values),
        "start_position": 1.5, "effective_rolling_radius": 0.31,
    }  # fmt: skip
    texts = [text for _, text in bench.link.state.log]
    assert texts == ["mode slip", "step from 1.5 m with r_e 0.31 m"]
    with pytest.raises(ValueError, match="effective_rolling_radius"):
        finished(bench.set_waveform("me", "step", values, 1.5, 3.1))
    with pytest.raises(ValueError, match="waveform 'stp' is not known"):
        waveform_of("stp", {})
    with pytest.raises(ValueError, match="kappa"):
        waveform_of("step", {"kappa": "1e7"})


def test_a_recording_has_its_facts_and_its_operator(bench, tmp_path):
    facts = {"tire": "TOY", "fz": 3700.0, "notes": "from the facts"}
    finished(bench.record("me", "run_1", "day", "a note", 1, facts))
    ((request_, fields),) = bench.link.done()
    record = yaml.safe_load(fields.pop("record"))
    assert request_ == "record"
    assert fields == {"name": "run_1", "folder": str(tmp_path / "day"), "at_once": True}
    assert record == {"tire": "TOY", "fz": 3700.0, "name": "run_1", "notes": "a note",
                      "operator": "My name"}  # fmt: skip
    assert (tmp_path / "day").is_dir() and bench.link.state.log[0][1] == "recording run_1"
    finished(bench.record("me", "run_2", "day", "", False, {}))
    assert yaml.safe_load(bench.link.done()[-1][1]["record"])["tire"]


def test_a_measurement_is_a_plan_for_a_folder(bench, tmp_path):
    assert finished(bench.measure("me", {"name": "x"}, "day")) == "measurement begun"
    finished(bench.measure("me", "name: y", "day"))
    assert finished(bench.cancel_measurement("me")) == "measurement is being stopped"
    first, second, third = bench.link.done()
    about = {"folder": str(tmp_path / "day"), "simulated": False}
    assert first == ("measure", {"plan": "name: x\n", **about})
    assert second == ("measure", {"plan": "name: y", **about}) and third == ("cancel", {})


def test_a_fit_is_loaded_by_its_path(bench, tmp_path):
    assert finished(bench.load_fit("me", "fits/a.yaml")) == "parasitic fit a.yaml loaded"
    assert bench.link.done() == [("load_fit", {"file": str((tmp_path / "fits/a.yaml").resolve())})]


def test_the_constants_of_both_nodes_are_shown_and_what_was_set_is_said(bench):
    found = finished(bench.constants())
    assert set(found) == {"et_value", "adapter_thickness", "wheel_camber_deg",
                          "road_camber_offset_deg", "slip_angle_offset_deg"}  # fmt: skip
    said = finished(bench.set_constants("me", {"et_value": 0.05, "slip_angle_offset_deg": 1}))
    assert said == "constants: et_value = 0.05, slip_angle_offset_deg = 1"


def test_a_refusal_is_in_the_log(bench):
    bench.link.reason = "the tire stands"
    with pytest.raises(ValueError, match="the tire stands"):
        finished(bench.quick_stop("me"))
    assert [text for _, text in bench.link.state.log] == ["refused: the tire stands"]


def test_the_log_is_short_and_the_latest_comes_first(bench):
    for number in range(60):
        bench.add_to_log(str(number))
    assert [text for _, text in bench.link.state.log] == [str(n) for n in range(59, 9, -1)]


def test_names_of_pages_are_short(bench):
    bench.charge.release_page("me")
    bench.take_charge("me", "x" * 50)
    assert bench.charge.name == "x" * 40
    bench.take_charge("me", "")
    assert bench.charge.name == "another page"


def test_a_page_gives_charge_back_and_only_its_own(bench):
    finished(bench.release_page("other"))
    assert bench.charge.holder == "me"
    finished(bench.release_page("me"))
    assert bench.charge.holder == "" and bench.link.asked == []
