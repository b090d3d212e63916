# SPDX-License-Identifier: Apache-2.0
"""The following error: a drive that no longer obeys is stopped, one that only reacts late or
speeds up slowly is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from drive_rig import PERIOD, Rig

from flatplank_hw.bus.image import Digital, Health
from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES

CODE = RULES["following_error"].code
SPEED = 0.1


class Slow(Rig):
    """A motor that reacts late and speeds up or brakes slowly, at rest still later."""

    late = 0
    """cycles until a set-point acts"""
    slowest = math.inf
    """acceleration [unit/s^2]"""
    kept = None
    deaf_to: Callable[[int], bool] = staticmethod(lambda mode: False)
    """modes whose set-points no longer act: the last one stays"""

    def obey(self, c) -> None:
        if self.deaf_to(c.mode):
            c = self.kept._replace(control_word=c.control_word)
        self.kept = c
        before = self.velocity
        if self.state is State.OPERATION_ENABLED and self.late:
            self.late -= 1
            c = c._replace(target_velocity=0, target_torque=0, mode=9)
        start = self.counts
        super().obey(c)
        most = self.slowest * PERIOD * 1e-9
        self.velocity = before + min(max(self.velocity - before, -most), most)
        self.counts = start + self.velocity * self.scale * PERIOD * 1e-9


def rolling(mode: str = "slip", value: float = SPEED, make: type = Slow, **parameters) -> Slow:
    """A motor that follows."""
    rig = make(**parameters)
    rig.run(2)
    assert rig.drive.set_operation_mode(mode, value).accepted
    assert rig.drive.enable().accepted
    rig.run(20, until=lambda s: s.state == State.OPERATION_ENABLED)
    if mode in ("slip", "free_rolling"):
        rig.load()
        rig.source, rig.reference = mode, value
        rig.plank(True)
    return rig


def seconds_to(rig: Rig, code: int, most: float = 2.0) -> float:
    """Time until the axis stops for a reason [s]."""
    first = rig.n
    rig.run(round(most / (PERIOD * 1e-9)), until=lambda s: s.stop_reason == code)
    return (rig.n - first) * PERIOD * 1e-9


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


def test_a_drive_that_does_not_stop_gets_no_commands_any_more():
    """The commands keep the number of an old cycle: the plant's watchdog and the guard act."""
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.quick_stop()
    rig.run(60)
    assert not rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.n - 1
    rig.run(40)
    assert rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.commands[-20].cycle
    assert "does_not_stop" in rig.drive.troubles
    rig.deaf = False
    rig.state = State.FAULT
    rig.run(5)
    assert not rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.n - 1


@pytest.mark.parametrize("again", [0, 30, 55])
def test_a_stop_that_the_drive_has_not_answered_outlasts_an_enable(again):
    """Enabled again, a deaf drive had the whole time of the following error once more."""
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.disable()
    for _ in range(again):
        rig.cycle()
    assert rig.drive.enable().accepted
    rig.run(60 - again)
    assert not rig.drive.does_not_stop
    rig.run(5)
    assert rig.drive.does_not_stop
    assert rig.commands[-1].cycle < rig.n - 1


def test_a_drive_that_is_enabled_at_once_after_a_stop_leaves_operation_first():
    rig = rolling()
    rig.run(100)
    rig.drive.disable()
    assert rig.drive.enable().accepted
    rig.run(50)
    states = [sample.state for sample in rig.samples[-50:]]
    assert {sample.stop_reason for sample in rig.samples[-50:]} == {0}
    assert State.QUICK_STOP_ACTIVE in states
    assert states[-1] is State.OPERATION_ENABLED
    assert rig.velocity == pytest.approx(SPEED, rel=1e-6)


def test_rules_apply_while_an_enable_waits_for_the_answer_to_a_stop():
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.disable()
    assert rig.drive.enable().accepted
    rig.run(10)
    rig.health = int(Health.LOST)
    rig.run(1)
    assert rig.samples[-1].stop_reason == RULES["inputs"].code


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
