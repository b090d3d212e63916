# SPDX-License-Identifier: Apache-2.0
"""A wheel that is to roll freely does not outrun the road."""

from __future__ import annotations

import math

import pytest
from drive_rig import PERIOD
from slow_motor import CODE, rolling, seconds_to

FASTEST = 0.03092 / 0.30
"""on the plank of the rig with its loaded radius [rad/s]"""


def seconds_outside(speed: float, fastest: float) -> float:
    """By hand: the time for which a wheel may turn faster than it can roll [s]."""
    v = speed - fastest - 0.005
    return ((0.005 + v) * 0.5 + v * v) / v


@pytest.mark.parametrize("torque", [6.0, 9.0, 12.0])
@pytest.mark.parametrize("radius", [0.30, 0.2, 0.33, math.nan, math.inf])
def test_a_free_rolling_wheel_that_outruns_the_road_is_stopped(torque, radius):
    """The motor of the rig turns at 0.02 rad/s per N m, whatever the road does."""
    rig = rolling("free_rolling", torque)
    rig.radius = radius
    speed = 0.02 * torque
    fastest = FASTEST if radius == 0.30 else 0.03092 / 0.318
    assert seconds_to(rig, CODE) == pytest.approx(seconds_outside(speed, fastest), abs=0.03)
    assert "rad, limit" in rig.drive.troubles["following_error"]


@pytest.mark.parametrize("per_s", [0.06, -0.06])
def test_a_free_rolling_wheel_that_speeds_up_gets_no_more_time(per_s):
    """A force that stays turns the wheel faster and faster, over a road that hardly moves."""
    rig = rolling("free_rolling", 0.0)
    rig.plank_velocity = 0.0015
    rig.run(50)
    began = rig.n
    for _ in range(400):
        rig.reference = per_s / 0.02 * (rig.n - began) * PERIOD * 1e-9
        if rig.cycle().stop_reason:
            break
    assert rig.samples[-1].stop_reason == CODE
    # by hand: t after the range is left v = 0.06 t, and v t = (0.005 + v) 0.5 + v^2 / 2 0.5
    inside = 0.005 if per_s < 0.0 else 0.005 + 0.0015 / 0.30
    assert (rig.n - began) * PERIOD * 1e-9 == pytest.approx(inside / 0.06 + 0.605, abs=0.03)


def test_a_free_rolling_wheel_that_leaves_the_range_again_has_the_whole_time():
    rig = rolling("free_rolling", 9.0)
    for _ in range(5):
        rig.reference = 9.0
        rig.run(100)
        rig.reference = 1.0
        rig.run(10)
    assert rig.samples[-1].stop_reason == 0


def test_a_free_rolling_wheel_that_turns_on_while_the_road_slows_down_is_stopped():
    rig = rolling("free_rolling", 5.0)
    rig.run(400)
    assert rig.samples[-1].stop_reason == 0
    rig.plank_velocity = 0.0015
    most = seconds_outside(0.1, 0.0015 / 0.30)
    assert seconds_to(rig, CODE) == pytest.approx(most, abs=0.03)


@pytest.mark.parametrize("torque", [0.0, 1.0, 5.0])
def test_every_speed_from_standing_to_rolling_is_free_rolling(torque):
    rig = rolling("free_rolling", torque)
    rig.run(1000)
    assert rig.samples[-1].stop_reason == 0


def test_a_wheel_that_turns_against_the_road_does_not_roll():
    rig = rolling("free_rolling", -2.0)
    assert seconds_to(rig, CODE) < 0.7


def test_a_torque_that_no_source_commands_may_turn_the_wheel_in_the_air():
    rig = rolling("torque", 12.0)
    rig.run(500)
    assert rig.velocity == pytest.approx(0.24, rel=1e-3)
    assert rig.samples[-1].stop_reason == 0
