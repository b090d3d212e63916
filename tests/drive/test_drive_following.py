# SPDX-License-Identifier: Apache-2.0
"""The following error: a drive that no longer obeys is stopped, one that only reacts late or
speeds up slowly is not."""

from __future__ import annotations

import math

import pytest
from drive_rig import PERIOD
from slow_motor import CODE, SPEED, Slow, rolling, seconds_to

from flatplank_hw.bus.image import Digital


@pytest.mark.parametrize("speed", [0.005, 0.1, 0.3, -0.1])
def test_a_blocked_motor_is_noticed_at_every_speed(speed):
    rig = rolling(value=speed)
    rig.run(50)
    assert rig.samples[-1].stop_reason == 0
    rig.dead_motor = True
    v = abs(speed)
    # by hand: v t = (0.005 + v) 0.5 + v^2 / 2 0.5
    assert seconds_to(rig, CODE) == pytest.approx(((0.005 + v) * 0.5 + v * v) / v, abs=0.025)
    assert "rad, limit" in rig.drive.troubles["following_error"]


def test_a_motor_that_goes_on_when_it_is_to_stand_is_stopped():
    """Its set-points no longer act, the state machine of the drive still does."""
    rig = rolling()
    rig.run(100)
    rig.deaf_to = lambda mode: True
    rig.plank_velocity = -0.03  # the axis is held: zero speed is commanded
    # by hand: 0.1 t = (0.005 + 0.1) 0.5 + 0.1^2 / 2 0.5
    assert seconds_to(rig, CODE) == pytest.approx(0.625, abs=0.025)
    rig.run(10)
    assert rig.velocity == 0.0


class Creeping(Slow):
    """A motor that speeds up by itself, whatever is commanded."""

    creep = 0.0
    """acceleration [unit/s^2]"""

    def obey(self, c) -> None:
        super().obey(c)
        if self.creep:
            self.own = getattr(self, "own", 0.0) + self.creep * PERIOD * 1e-9
            start = self.counts - self.velocity * self.scale * PERIOD * 1e-9
            self.velocity = self.own
            self.counts = start + self.velocity * self.scale * PERIOD * 1e-9


def test_a_motor_that_runs_away_from_standing_gets_no_room_by_its_speed():
    """Held at rest it speeds up slowly: it turned by 6 deg until it was noticed."""
    rig = rolling("velocity", 0.0, make=Creeping)
    rig.run(50)
    rig.creep = 0.12
    # by hand: 0.12 t^2 / 2 = 0.005 * 0.5
    assert seconds_to(rig, CODE) == pytest.approx(math.sqrt(2.0 * 0.0025 / 0.12), abs=0.03)


class Still(Slow):
    """A motor whose inputs may stay as they are, whatever it does."""

    still = False
    shown = None

    def image(self, n: int, stamp: int):
        inputs = super().image(n, stamp)
        self.shown = self.shown if self.still and self.shown else inputs.axes
        return inputs._replace(axes=self.shown)


@pytest.mark.parametrize("moved_on_s", [0.0, 0.1, 0.3, 0.55])
def test_inputs_that_no_longer_change_do_not_hide_a_motor_that_turns_on(moved_on_s):
    """The counter stands, as commanded, and the speed that is shown contradicts it."""
    rig = rolling(make=Still)
    rig.run(100)
    rig.deaf_to = lambda mode: True
    rig.plank_velocity = -0.03  # the axis is held: zero speed is commanded
    rig.run(1 + round(moved_on_s / (PERIOD * 1e-9)))
    rig.still = True
    # by hand: 0.1 t = (0.005 + 0.1) 0.5 + 0.1^2 / 2 0.5, as without it
    assert seconds_to(rig, CODE) == pytest.approx(0.625 - moved_on_s, abs=0.025)


@pytest.mark.parametrize("speed", [0.005, 0.1, -0.3])
def test_inputs_that_no_longer_change_are_noticed_at_every_commanded_speed(speed):
    """The speed that is shown is the commanded one, and the counter contradicts it."""
    rig = rolling(value=speed, make=Still)
    rig.run(100)
    rig.still = True
    # by hand, no speed has changed: v t = 0.005 0.5; a standing motor of this speed has 1 s
    v = abs(speed)
    most = ((0.005 + v) * 0.5 + v * v) / v
    assert seconds_to(rig, CODE) < most


def test_a_free_rolling_wheel_whose_inputs_no_longer_change_does_not_outrun_the_road():
    """The counter stands, and the speed that is shown is more than the largest slip."""
    rig = rolling("free_rolling", 5.0, make=Still)
    rig.run(100)
    rig.still, rig.plank_velocity = True, 0.0015
    # by hand: as with a counter that runs on
    assert seconds_to(rig, CODE) == pytest.approx(0.62, abs=0.03)


@pytest.mark.parametrize("creeps", [0.006, 0.014, 0.05])
def test_a_motor_that_brakes_and_creeps_on_is_noticed_as_soon(creeps):
    """It took 2 s: the travel of a creeping motor grows slowly."""
    rig = rolling()
    rig.run(100)
    kept = rig.obey
    turning = round(creeps * rig.scale)
    rig.obey = lambda c: kept(c._replace(target_velocity=max(c.target_velocity, turning)))
    rig.reference = 0.0
    # by hand: t = (0.005 + 0.1) 0.5 / 0.1 + 0.1 / 0.5
    assert seconds_to(rig, CODE) == pytest.approx(0.725, abs=0.025)


def test_a_motor_that_keeps_a_slightly_higher_speed_is_noticed_soon():
    """The speed that is missing counts, not the speed."""
    rig = rolling(value=0.15)
    rig.run(100)
    rig.deaf_to = lambda mode: True
    rig.reference = 0.1
    # by hand: 0.05 t = (0.005 + 0.05) 0.5 + 0.05^2 / 2 0.5
    assert seconds_to(rig, CODE) == pytest.approx(0.6, abs=0.025)


def test_a_motor_of_the_wrong_speed_is_noticed():
    rig = rolling()
    rig.run(100)
    kept = rig.obey

    def slower(c):
        kept(c)
        rig.counts -= 0.2 * rig.velocity * rig.scale * PERIOD * 1e-9

    rig.obey = slower
    assert seconds_to(rig, CODE, 5.0) < 4.0


class LateStep(Slow):
    """A turning motor keeps its speed for 0.45 s when its set-point jumps: thesis 6.3."""

    kept_for = 0

    def obey(self, c) -> None:
        jumps = self.kept is not None and abs(c.target_velocity - self.kept.target_velocity) > 1e3
        self.kept_for = self.kept_for + 1 if jumps else 0
        old = jumps and self.kept_for * PERIOD < 450_000_000
        kept = self.kept if old else c
        super().obey(kept._replace(control_word=c.control_word))


@pytest.mark.parametrize("slip", [-0.3, -0.1, 0.01, 0.1, 0.3, 0.5])
def test_a_step_that_comes_as_late_as_that_of_the_thesis_is_no_error(slip):
    rig = rolling(make=LateStep)
    rig.run(100)
    rig.reference = SPEED * (1.0 + slip)
    rig.run(500)
    assert rig.samples[-1].stop_reason == 0
    assert rig.velocity == pytest.approx(SPEED * (1.0 + slip), rel=1e-4)


@pytest.mark.parametrize("late_s", [0.0, 0.15, 0.45])
@pytest.mark.parametrize("slowest", [math.inf, 0.5])
def test_a_late_start_and_a_slow_motor_are_no_error(late_s, slowest):
    rig = rolling()
    rig.late, rig.slowest = round(late_s / (PERIOD * 1e-9)), slowest
    for speed in (SPEED, 0.0, 0.3, -0.3, 0.005):
        rig.reference = speed
        rig.run(500)
        assert rig.samples[-1].stop_reason == 0
    assert rig.velocity == pytest.approx(0.005, rel=1e-3)


def test_braking_on_a_hold_is_no_error():
    rig = rolling(value=0.3)
    rig.slowest = 0.5
    rig.run(400)
    rig.plank_velocity = -0.03
    rig.run(500)
    rig.plank_velocity = 0.03
    rig.run(500)
    assert rig.velocity == pytest.approx(0.3, rel=1e-6)


def test_a_move_is_followed_and_a_blocked_one_is_noticed():
    rig = rolling("position")
    rig.drive.move_to(0.3)
    rig.run(2000, until=lambda s: rig.drive.at_target)
    rig.drive.move_to(-0.3)
    rig.run(200)
    rig.dead_motor = True
    # by hand: 0.15 t = (0.005 + 0.15) 0.5 + 0.15^2 / 2 0.5
    assert seconds_to(rig, CODE) < 0.7


def test_a_motor_that_leaves_its_place_is_noticed():
    rig = rolling("position")
    rig.run(50)
    rig.dead_motor = True
    for _ in range(200):
        rig.counts += 1e-4 * rig.scale  # 0.025 rad/s
        rig.cycle()
    assert rig.samples[-1].stop_reason == CODE


@pytest.mark.parametrize(("torque", "stops"), [(3.0 - 0.1, False), (3.0 + 0.1, True)])
def test_a_torque_that_is_not_the_commanded_one_is_noticed(torque, stops):
    """The margin is torque_trip - torque_limit, 3 N m."""
    rig = rolling("torque", 4.0)
    rig.run(100)
    assert rig.samples[-1].stop_reason == 0
    kept = rig.obey

    def weak(c):
        kept(c)
        rig.torque -= torque if rig.torque else 0.0

    rig.obey = weak
    rig.run(120)
    assert rig.samples[-1].stop_reason == 0
    rig.run(40)
    assert (rig.samples[-1].stop_reason == CODE) is stops


@pytest.mark.parametrize(
    ("switch", "axis", "stops"),
    [(Digital.LIMIT_REAR, "plank", False), (Digital.LIMIT_FRONT, "plank", True),
     (Digital.LIMIT_REAR, "wheel", True)],
)  # fmt: skip
def test_a_plank_that_a_limit_switch_holds_is_no_error(switch, axis, stops):
    rig = rolling("velocity", -SPEED, axis=axis, rules=("following_error",))
    rig.run(100)
    rig.dead_motor, rig.digital = True, int(Digital.EMERGENCY_STOP_OK | switch)
    rig.run(300)
    assert (rig.samples[-1].stop_reason == CODE) is stops


def test_homing_and_a_disabled_axis_have_no_following_error():
    rig = rolling("position")
    rig.drive.move_to(0.5)
    rig.run(5000, until=lambda s: rig.drive.at_target)
    assert rig.drive.home().accepted
    rig.run(50)
    assert rig.samples[-1].stop_reason == 0 and rig.drive.mode == "position"
    rig.drive.disable()
    rig.run(50)
    rig.counts += rig.scale  # turned by hand
    rig.run(10)
    assert rig.drive.enable().accepted
    rig.run(200)
    assert rig.samples[-1].stop_reason == 0


def test_two_images_of_one_stamp_do_not_end_the_node():
    """Stamps of the bus that stand still for a cycle; the wheel is outside of the range."""
    rig = rolling("free_rolling", 8.0)
    rig.run(20)
    for _ in range(2):
        inputs = rig.image(rig.n, rig.n * PERIOD)
        _, sample = rig.drive.step(inputs, rig._encoders, rig._hub, None)
        rig.counts += 0.001 * rig.scale
    assert sample.stop_reason == 0
    assert math.isfinite(rig.drive._watch.situation.following_limit)
