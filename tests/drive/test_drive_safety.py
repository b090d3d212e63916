# SPDX-License-Identifier: Apache-2.0
"""Every safety rule stops the wheel in time, says why, and lets go only when it should."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from drive_rig import PERIOD, Rig, up

from flatplank_hw.cia402 import State
from flatplank_hw.drive import REASONS, DriveParameters
from flatplank_hw.drive.safety import RULES, Situation, first_stop


def overspeed(rig: Rig) -> None:
    rig.velocity = 1.0


def set_attribute(name: str, value) -> Callable[[Rig], None]:
    return lambda rig: setattr(rig, name, value)


def dead_bus(rig: Rig) -> None:
    rig.n += 25


CAUSES: dict[str, tuple[Callable[[Rig], None], Callable[[Rig], None]]] = {
    "inputs": (set_attribute("health", 2), set_attribute("health", 0)),
    "samples": (set_attribute("encoders_alive", False), set_attribute("encoders_alive", True)),
    "drive_fault": (Rig.fault, lambda rig: rig.drive.reset_fault()),
    "emergency_stop": (set_attribute("digital", 0), set_attribute("digital", 2)),
    "heartbeat": (set_attribute("beat", ""), lambda rig: None),
    "speed": (overspeed, lambda rig: None),
    "torque": (set_attribute("torque", 16.0), lambda rig: None),
    "following_error": (set_attribute("dead_motor", True), set_attribute("dead_motor", False)),
    "fz": (set_attribute("fz", 8500.0), set_attribute("fz", 3700.0)),
    "road_end": (set_attribute("plank_position", 4.2001), set_attribute("plank_position", 1.0)),
    "steering": (set_attribute("steer", math.radians(-48.1)), set_attribute("steer", 0.0)),
    "plank_stopped": (lambda rig: rig.plank(False), lambda rig: rig.plank(True)),
    "plank_reverses": (
        set_attribute("plank_velocity", -0.03),
        set_attribute("plank_velocity", 0.03),
    ),
    "reference": (set_attribute("reference", None), set_attribute("reference", 0.1)),
}
"""rule -> what a test does to the running bench, and what takes the cause away"""


def running() -> Rig:
    """Slip control under way on a loaded tire, an operator in charge."""
    rig = up("slip")
    rig.load()
    rig.reference = 0.1
    assert rig.drive.claim("panel").accepted
    rig.beat = "panel"
    rig.run(5)
    rig.plank(True)
    rig.run(100)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)
    return rig


def test_every_rule_has_a_scenario_or_is_the_waiting_one():
    elsewhere = {"plank_stands", "reference_gone", "wheel_stopped"}
    assert set(CAUSES) | elsewhere == set(RULES)


def test_an_axis_without_a_road_stops_when_its_controller_falls_silent():
    p = DriveParameters(rules=("reference_gone",))
    rule = RULES["reference_gone"]
    in_time = Situation(follows_reference=True, reference_age_ns=40_000_000)
    assert first_stop((rule,), in_time, p) is None
    late = Situation(follows_reference=True, reference_age_ns=60_000_000)
    assert first_stop((rule,), late, p) is rule


@pytest.mark.parametrize("name", CAUSES)
def test_the_wheel_stops_in_time_and_says_why(name):
    rig = running()
    cause, _ = CAUSES[name]
    start = rig.n
    cause(rig)
    waits = {"heartbeat": 0.5, "fz": 0.05, "torque": 0.05, "following_error": 0.625}.get(name, 0.0)
    # the ideal motor of the rig must get the message early enough to leave time for braking
    while rig.velocity != 0.0 or not rig.samples[-1].stop_reason:
        rig.cycle()
        if name == "torque":
            rig.torque = 16.0
        assert (rig.n - start) * PERIOD * 1e-9 <= waits + 0.08
    sample = rig.run(1)
    assert sample.stop_reason == RULES[name].code
    assert REASONS[sample.stop_reason] == RULES[name].text


@pytest.mark.parametrize("name", [n for n in CAUSES if RULES[n].latching])
def test_a_latched_stop_stays_until_it_is_enabled_again(name):
    rig = running()
    cause, cure = CAUSES[name]
    cause(rig)
    rig.run(200, until=lambda s: s.stop_reason == RULES[name].code)
    rig.run(5)
    still_there = name not in (
        "heartbeat", "speed", "torque", "plank_stopped", "reference", "following_error"
    )  # fmt: skip
    if name == "samples":
        still_there = True
    if still_there:
        assert not rig.drive.enable().accepted
    cure(rig)
    sample = rig.run(100)
    assert rig.velocity == 0.0
    assert sample.stop_reason == (0 if name == "drive_fault" else RULES[name].code)
    assert rig.drive.enable().accepted
    rig.run(10, until=lambda s: s.state == State.OPERATION_ENABLED)


@pytest.mark.parametrize("name", ["inputs", "samples", "emergency_stop"])
def test_a_reset_is_refused_while_the_cause_is_there(name):
    rig = running()
    cause, cure = CAUSES[name]
    cause(rig)
    rig.run(150, until=lambda s: s.stop_reason == RULES[name].code)
    refused = rig.drive.reset_fault()
    assert not refused.accepted and RULES[name].text in refused.reason
    cure(rig)
    rig.run(5)
    assert rig.drive.reset_fault().accepted


def test_reversing_only_holds():
    rig = running()
    rig.plank_velocity = -0.03
    rig.run(10)
    assert rig.velocity == 0.0
    rig.plank_velocity = 0.03
    rig.run(5)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)


def test_waiting_for_the_plank_does_not_latch():
    rig = up("slip")
    rig.load()
    rig.reference = 0.1
    sample = rig.run(500)
    assert sample.stop_reason == RULES["plank_stands"].code
    rig.plank(True)
    rig.run(5)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)
    assert rig.samples[-1].stop_reason == 0


def test_lowering_a_resting_tire_is_no_stop():
    rig = up("position")
    rig.drive.move_to(0.1)
    rig.run(2000, until=lambda s: rig.drive.at_target)
    rig.run(5)
    rig.load()
    sample = rig.run(100)
    assert sample.stop_reason == RULES["plank_stands"].code
    assert sample.state == State.OPERATION_ENABLED
    assert rig.drive.set_operation_mode("slip").accepted


@pytest.mark.parametrize(
    ("radius", "fz", "turns"),
    [(0.3201, 0.0, True), (0.3199, 0.0, False), (0.33, 401.0, False), (0.33, -399.0, True)],
)
def test_an_unloaded_tire_may_be_turned(radius, fz, turns):
    rig = up("velocity", 0.1)
    rig.radius, rig.fz = radius, fz
    rig.run(150)
    assert (rig.velocity > 0.0) == turns


def test_silence_of_the_bus_stops():
    rig = running()
    dead_bus(rig)
    rig.run(3)
    assert rig.samples[-1].stop_reason == RULES["inputs"].code
    assert rig.velocity == 0.0


def test_short_peaks_of_load_do_not_trip():
    rig = running()
    for _ in range(5):
        rig.fz = 8600.0
        rig.run(10)
        rig.fz = 3700.0
        rig.run(2)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize(
    ("attribute", "name"), [("fz", "fz"), ("steer", "steering"), ("plank_position", "road_end")]
)
def test_nan_does_not_pass_for_safe(attribute, name):
    """What comes as counts is always a number; `test_drive_rules.py` asks the rules alone."""
    rig = running()
    setattr(rig, attribute, math.nan)
    rig.run(30)
    assert rig.velocity == 0.0
    assert rig.samples[-1].stop_reason == RULES[name].code


def test_a_free_wheel_may_turn_at_the_end_of_the_road():
    rig = up("velocity", 0.1)
    rig.plank_position = 4.3
    rig.run(150)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)
    rig.load()
    rig.moving = True
    rig.run(10)
    assert rig.velocity == 0.0
    assert rig.samples[-1].stop_reason == RULES["road_end"].code


def test_without_a_claim_no_heartbeat_is_needed():
    rig = up("slip")
    rig.load()
    rig.reference = 0.1
    rig.plank(True)
    rig.run(1000)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)


def test_claims():
    rig = up("slip")
    assert not rig.drive.claim("").accepted
    assert rig.drive.claim("panel").accepted
    rig.run(1)
    assert "'panel' is in charge" in rig.drive.claim("other").reason
    assert not rig.drive.heartbeat("other").accepted
    assert rig.drive.release().accepted
    rig.run(500)
    assert rig.drive.claim("other").accepted


def test_rules_alone():
    p = DriveParameters()
    order = tuple(RULES[name] for name in p.rules)
    calm = Situation(moving=True, plank_velocity=0.03, loaded_radius=0.3, fz=3700.0)
    assert first_stop(order, calm, p) is None
    calm.moving = False
    assert first_stop(order, calm, p).name == "plank_stands"
    assert len({rule.code for rule in RULES.values()}) == len(RULES)
    assert all(rule.text and REASONS[rule.code] == rule.text for rule in RULES.values())


def test_unknown_rule_names_the_nearest():
    with pytest.raises(ValueError, match="unknown rule 'plank_stoped'; the nearest"):
        DriveParameters(rules=("plank_stoped",))
