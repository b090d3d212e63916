# SPDX-License-Identifier: Apache-2.0
"""The safety rules one by one, by their registry: what each stops, and that nothing else does it
in its place.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from flatplank_data.params import load_parameter_set
from flatplank_hw.bus.image import AXES, Health
from flatplank_hw.cia402 import CiaMode, State
from flatplank_hw.drive import DriveParameters
from flatplank_hw.drive.following import Following
from flatplank_hw.drive.modes import SetPoint
from flatplank_hw.drive.safety import (
    REASONS,
    RULES,
    Situation,
    first_stop,
    is_latched,
    may_turn,
    unloaded,
)
from flatplank_hw.drive.shaft import Shaft
from flatplank_hw.drive.watch import Watch
from flatplank_hw.share import config_file

MS = 1_000_000
NAN = math.nan

CALM = Situation(
    state=State.OPERATION_ENABLED, follows_reference=True, turning=True, moving=True,
    plank_velocity=0.03, plank_position=1.0, steer_angle=0.1, loaded_radius=0.3, fz=3700.0,
    speed=0.1, claimed=True, heartbeat_age_ns=400 * MS, sample_age_ns=40 * MS, gap_ns=40 * MS,
    reference_age_ns=40 * MS, fz_high_ns=40 * MS, torque_high_ns=40 * MS, following_error=0.02,
    following_limit=0.03, torque_off_ns=499 * MS,
)  # fmt: skip
"""a loaded wheel that follows the plank: everything just within its limit"""

STOPS: dict[str, list[dict]] = {
    "inputs": [
        {"health": Health.STALE}, {"health": Health.LOST}, {"gap_ns": 43 * MS}, {"gap_ns": -1}
    ],
    "samples": [{"sample_age_ns": 43 * MS}],
    "drive_fault": [{"state": State.FAULT}, {"state": State.FAULT_REACTION_ACTIVE}],
    "emergency_stop": [{"digital": 0}],
    "heartbeat": [{"heartbeat_age_ns": 501 * MS}],
    "speed": [{"speed": 0.41}, {"speed": -0.41}, {"speed": NAN}],
    "torque": [{"torque_high_ns": 51 * MS}],
    "fz": [{"fz_high_ns": 51 * MS}],
    "road_end": [{"plank_position": 4.21}, {"plank_position": NAN}],
    "steering": [{"steer_angle": 0.84}, {"steer_angle": -0.84}, {"steer_angle": NAN}],
    "plank_stopped": [{"moving": False}],
    "plank_stands": [
        {"moving": False, "turning": False},
        # free, but it waits for the plank
        {"moving": False, "turning": False, "loaded_radius": 0.325, "fz": 0.0},
        # no plank to wait for, but not known to be free
        {"moving": False, "turning": False, "follows_reference": False},
        {"moving": False, "turning": False, "follows_reference": False, "fz": 0.0},
        {"moving": False, "turning": False, "follows_reference": False, "loaded_radius": 0.325},
        {"moving": False, "turning": False, "follows_reference": False, "loaded_radius": 0.325,
         "fz": NAN},
        {"moving": False, "turning": False, "follows_reference": False, "loaded_radius": NAN,
         "fz": 0.0},
    ],
    "plank_reverses": [{"plank_velocity": -0.001}, {"plank_velocity": NAN}],
    "reference": [{"reference_age_ns": 43 * MS}],
    "reference_gone": [{"reference_age_ns": 43 * MS}],
    "following_error": [
        {"following_error": 0.031}, {"following_error": -0.031}, {"following_error": NAN},
        {"following_limit": NAN}, {"torque_off_ns": 501 * MS},
    ],
    "wheel_stopped": [
        {"wheel_left": True},
        {"wheel_left": True, "loaded_radius": 0.325},
        {"wheel_left": True, "fz": NAN, "loaded_radius": 0.325},
    ],
}  # fmt: skip
"""rule -> what changes in the calm situation, each of which alone stops the axis"""

PASSES: dict[str, list[dict]] = {
    "heartbeat": [{"heartbeat_age_ns": 501 * MS, "claimed": False}],
    "road_end": [{"plank_position": 4.21, "loaded_radius": 0.325, "fz": 0.0}],
    "plank_stopped": [
        {"moving": False, "turning": False},
        {"moving": False, "follows_reference": False, "loaded_radius": 0.325, "fz": 0.0},
    ],
    "plank_stands": [
        {"moving": False, "follows_reference": False, "loaded_radius": 0.325, "fz": 0.0}
    ],
    "plank_reverses": [
        {"plank_velocity": -0.0004},
        {"plank_velocity": -0.03, "follows_reference": False},
    ],
    "reference": [
        {"reference_age_ns": 43 * MS, "moving": False},
        {"reference_age_ns": 43 * MS, "follows_reference": False},
    ],
    "reference_gone": [{"reference_age_ns": 43 * MS, "follows_reference": False}],
    "wheel_stopped": [{"wheel_left": True, "loaded_radius": 0.325, "fz": 0.0}],
}
"""rule -> what it lets pass, although it looks like a cause"""

EVERY_AXIS = {"inputs", "samples", "drive_fault", "emergency_stop", "heartbeat", "speed", "torque"}
EVERY_AXIS |= {"fz", "following_error"}
ROAD = {"road_end", "steering", "plank_stopped", "plank_stands", "plank_reverses", "reference"}
AXIS_RULES = {
    "wheel": EVERY_AXIS | ROAD,
    "plank": EVERY_AXIS | {"wheel_stopped"},
    **dict.fromkeys(("steer", "camber", "vertical"), EVERY_AXIS | {"reference_gone"}),
}
IN_ITS_PLACE = {"plank_stopped": "plank_stands"}
"""what holds the wheel when a rule is taken out; of all others, nothing does"""


def parameters(axis: str) -> DriveParameters:
    return load_parameter_set(
        DriveParameters, config_file("flatplank_hw", f"{axis}_drive.yaml"), f"{axis}_drive"
    )


def asked(names, facts: dict) -> str | None:
    """Name of the first rule that stops the calm situation with some facts changed."""
    p = DriveParameters()
    rule = first_stop(tuple(RULES[name] for name in names), replace(CALM, **facts), p)
    return None if rule is None else rule.name


def test_the_tables_walk_the_whole_registry():
    assert set(STOPS) == set(RULES)
    assert set(AXIS_RULES) == set(AXES)


@pytest.mark.parametrize("axis", AXIS_RULES)
def test_every_axis_asks_its_rules(axis):
    assert set(parameters(axis).rules) == AXIS_RULES[axis]
    if axis == "wheel":
        assert set(DriveParameters().rules) == AXIS_RULES[axis]


@pytest.mark.parametrize(
    ("name", "facts"), [(name, facts) for name, many in STOPS.items() for facts in many]
)
def test_a_rule_stops_and_nothing_else_would(name, facts):
    others = [n for n in RULES if n not in (name, "reference", "reference_gone")]
    assert asked(RULES, {}) is None
    assert asked([name], facts) == name
    assert asked(others, facts) == IN_ITS_PLACE.get(name)


@pytest.mark.parametrize(
    ("name", "facts"), [(name, facts) for name, many in PASSES.items() for facts in many]
)
def test_a_rule_lets_pass_what_is_safe(name, facts):
    assert asked([name], facts) is None


def test_an_axis_that_was_never_enabled_begins_at_rest():
    """References are due from bench time 0, the motor is at count 0, and nothing ran before."""
    p = DriveParameters()
    watch, shaft, following = Watch(p), Shaft(p), Following(p)
    watch.update_reference(5 * MS, True, None)
    assert watch.situation.reference_age_ns == 5 * MS
    assert shaft.raw_position(NAN) == 0 and not shaft.known
    new, past = Situation(), Situation()
    point = SetPoint(CiaMode.CYCLIC_VELOCITY, NAN, 0.05, NAN)
    for s, begun in ((new, following), (past, Following(p))):
        if s is past:
            begun.reset(s)
        for _ in range(3):
            begun.update(s, point, shaft, 4 * MS)
    assert new.following_limit == past.following_limit > 0.0
    assert new.following_error == past.following_error == pytest.approx(2 * 0.05 * 0.004)


@pytest.mark.parametrize(("torque", "high"), [(14.9, 0), (15.1, 4), (-15.1, 4), (NAN, 4)])
def test_torque_counts_as_high_in_both_senses_and_when_it_is_no_number(torque, high):
    watch = Watch(DriveParameters())
    inputs = SimpleNamespace(health=0, digital=2, stamp_ns=0)
    shaft = SimpleNamespace(velocity=0.0, torque=torque)
    watch.update_from_bus(inputs, State.OPERATION_ENABLED, shaft, 4 * MS)
    assert watch.situation.torque_high_ns == high * MS


@pytest.mark.parametrize(
    ("fz", "high"), [(8399.0, 0), (-8399.0, 0), (8401.0, 4), (-8401.0, 4), (NAN, 4)]
)
def test_fz_counts_as_high_in_both_senses_and_when_it_is_no_number(fz, high):
    watch = Watch(DriveParameters())
    hub = SimpleNamespace(loaded_radius=0.3, fz_filtered=fz, stamp_ns=0)
    watch.update_from_samples(0, 4 * MS, None, hub)
    assert watch.situation.fz_high_ns == high * MS


@pytest.mark.parametrize(
    ("fz", "clear"),
    [(0.0, True), (399.0, True), (-399.0, True), (401.0, False), (-401.0, False),
     (-9000.0, False), (NAN, False), (-math.inf, False)],
)  # fmt: skip
def test_only_a_tire_with_almost_no_force_is_unloaded(fz, clear):
    """A large force of either sign is a load, or a hub that cannot tell."""
    s = Situation(loaded_radius=0.325, fz=fz)
    assert unloaded(s, DriveParameters()) is clear
    assert may_turn(s, DriveParameters()) is clear


def test_only_a_plank_that_stands_or_reverses_holds_the_axis_without_a_latch():
    """Codes 1 to 17 are rules, 20 to 22 other stops; 0 is none."""
    assert set(REASONS) == {0, *range(1, 18), 20, 21, 22}
    assert {code for code in REASONS if not is_latched(code)} == {
        0, RULES["plank_stands"].code, RULES["plank_reverses"].code,
    }  # fmt: skip
