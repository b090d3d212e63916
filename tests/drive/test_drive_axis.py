# SPDX-License-Identifier: Apache-2.0
"""The drive core on the rig: enabling, modes, moves, homing, faults, requests."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from drive_rig import Rig, up

from flatplank_hw.bus.image import AxisInputs
from flatplank_hw.cia402 import HOMING_ATTAINED, CiaMode, State
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.drive.modes import MODES, HomingSequence, Move
from flatplank_hw.drive.safety import LEFT_OPERATION, NO_ANSWER, QUICK_STOP, RULES
from flatplank_hw.drive.shaft import Shaft

NAN, INF = math.nan, math.inf


def test_enable_comes_up_without_a_jump():
    rig = Rig(start_counts=2**31 - 3)
    rig.run(5)
    counts = rig.counts
    answer = rig.drive.enable()
    assert answer == (True, "the drive is enabled in mode position, from cycle 5", 5)
    rig.run(200)
    assert rig.state is State.OPERATION_ENABLED
    assert rig.counts == counts
    raw = (math.floor(counts) + 2**31) % 2**32 - 2**31
    assert all(c.target_position == raw and c.target_velocity == 0 for c in rig.commands)


def test_enable_needs_inputs():
    assert "start the bus" in AxisDrive(DriveParameters()).enable().reason


@pytest.mark.parametrize("name", [name for name in MODES if name != "follow"])
def test_every_mode_can_be_chosen_and_stands_while_the_tire_stands_on_the_road(name):
    if name == "homing":
        rig = up()
        rig.load()
        rig.run(2)
        assert rig.drive.home().accepted
    else:
        rig = Rig()
        rig.load()
        rig.run(2)
        assert rig.drive.set_operation_mode(name, 0.1).accepted
        rig.drive.enable()
    mode = MODES[name]
    rig.source, rig.reference = mode.source or "slip", 0.1
    counts = rig.counts
    rig.run(100)
    assert rig.state is State.OPERATION_ENABLED
    if name == "homing":
        assert rig.samples[-1].position == 0.0
        assert rig.drive.mode == "position"
        return
    assert rig.counts == counts
    assert rig.samples[-1].mode == mode.code
    assert rig.samples[-1].stop_reason == RULES["plank_stands"].code


@pytest.mark.parametrize("name", MODES)
def test_every_mode_has_its_own_name_and_code(name):
    assert MODES[name].name == name
    assert sum(mode.code == MODES[name].code for mode in MODES.values()) == 1


@pytest.mark.parametrize("name", ["position", "velocity", "torque"])
@pytest.mark.parametrize("value", [NAN, INF, 1e6, -1e6])
def test_values_that_make_no_sense_are_refused(name, value):
    rig = up("velocity", 0.0)
    before = rig.run(2)
    answer = rig.drive.set_operation_mode(name, value)
    assert not answer.accepted
    assert answer.reason
    after = rig.run(5)
    assert (after.mode, after.state) == (before.mode, before.state)


def test_unknown_mode_names_the_nearest():
    rig = up()
    assert "nearest is 'velocity'" in rig.drive.set_operation_mode("velocty").reason


def test_slip_starts_by_itself_with_the_plank_and_listens_only_to_its_source():
    rig = up("slip")
    rig.load()
    rig.source, rig.reference = "free_rolling", 5.0
    rig.run(50)
    assert rig.drive.reference_source == "slip"
    rig.source, rig.reference = "slip", 0.1
    rig.run(50)
    assert rig.velocity == 0.0
    rig.plank(True)
    rig.run(5)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)
    rig.source, rig.reference = "free_rolling", 5.0
    rig.run(5)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)


def test_free_rolling_sends_torque():
    rig = up("free_rolling")
    rig.load()
    rig.source, rig.reference = "free_rolling", 2.5
    rig.plank(True)
    rig.run(10)
    assert rig.commands[-1].mode == 10
    assert rig.torque == pytest.approx(2.5)
    rig.reference = rig.drive.parameters.torque_limit
    rig.run(3)
    assert rig.commands[-1].target_torque == round(rig.drive.parameters.torque_limit * 1e4)


def test_velocity_ramps():
    rig = up("velocity", 0.1)
    rig.run(200)
    assert rig.velocity == pytest.approx(0.1, rel=1e-6)
    steps = [b.target_velocity - a.target_velocity for a, b in zip(rig.commands, rig.commands[1:])]  # noqa: B905
    assert max(steps) <= 0.5 * 0.004 * rig.scale + 1


@pytest.mark.parametrize("angle", [2 * math.pi / 3, -1.0, 6 * math.pi, 1e-6])
def test_move_goes_there_without_overshoot(angle):
    rig = up()
    assert rig.drive.move_to(angle).accepted
    rig.run(60_000, until=lambda s: rig.drive.at_target)
    sample = rig.run(10)
    assert sample.position == pytest.approx(angle, abs=2e-9)
    positions = [s.position * math.copysign(1, angle) for s in rig.samples]
    assert max(positions) < abs(angle) + 1e-8
    speeds = [
        abs(s.reference_velocity)
        for s in rig.samples
        if s.reference_velocity == s.reference_velocity
    ]
    assert max(speeds) <= rig.drive.parameters.move_speed + 1e-12


def test_move_is_refused_on_the_road_and_when_disabled():
    rig = Rig()
    rig.run(2)
    assert "enable it first" in rig.drive.move_to(1.0).reason
    rig = up()
    rig.load()
    rig.run(2)
    assert "unload" in rig.drive.move_to(1.0).reason
    rig = up()
    assert "must be within" in rig.drive.move_to(1e4).reason
    assert "speed is nan" in rig.drive.move_to(1.0, speed=NAN).reason


def test_a_move_is_refused_while_the_drive_comes_up_and_when_it_goes_down():
    rig = Rig()
    rig.run(5)
    assert rig.drive.enable().accepted
    rig.run(1)
    assert rig.state is not State.OPERATION_ENABLED
    assert "enable it first" in rig.drive.move_to(1.0).reason
    rig.run(200)
    assert rig.drive.move_to(1.0).accepted
    assert rig.drive.disable().accepted
    rig.run(1)
    assert "enable it first" in rig.drive.move_to(2.0).reason


def test_a_new_target_is_taken_on_the_way():
    rig = up()
    rig.drive.move_to(1.0)
    rig.run(200)
    rig.drive.move_to(-0.2)
    rig.run(20_000, until=lambda s: rig.drive.at_target)
    assert rig.run(5).position == pytest.approx(-0.2, abs=2e-9)


def test_a_move_ends_the_mode_of_an_axis_that_rests():
    rig = up("velocity", 0.1)
    rig.run(100)
    assert "turns" in rig.drive.move_to(0.2).reason
    assert rig.drive.set_operation_mode("velocity", 0.0).accepted
    rig.run(200)
    assert rig.drive.move_to(0.2).accepted
    rig.run(20_000, until=lambda s: rig.drive.at_target)
    assert rig.drive.mode == "position"
    assert rig.run(5).position == pytest.approx(0.2, abs=2e-9)


@pytest.mark.parametrize("ahead", [1e-6, -1e-6, -0.01])
def test_a_target_near_a_moving_axis_is_reached_without_a_jump_of_the_speed(ahead):
    """It is too late to stop there: the axis brakes, and comes back."""
    move, dt = Move(speed=0.1, acceleration=0.5), 0.004
    move.target = 1.0
    for _ in range(100):
        move.step(dt)
    assert move.velocity == pytest.approx(0.1)
    move.target = move.position + ahead
    speeds = [move.velocity]
    for _ in range(1000):
        move.step(dt)
        speeds.append(move.velocity)
    # the last step takes the rest, at most twice the others
    assert np.abs(np.diff(speeds)).max() <= 2.0 * move.acceleration * dt + 1e-12
    assert move.position == move.target and move.velocity == 0.0


def test_a_move_takes_the_time_of_its_trapezoid_and_never_brakes_harder():
    move, dt = Move(speed=0.15, acceleration=0.5), 0.004
    move.target = 0.3
    speeds = [0.0]
    while move.position != move.target:
        move.step(dt)
        speeds.append(move.velocity)
    # by hand: 0.3 / 0.15 s + 0.15 / 0.5 s
    assert (len(speeds) - 1) * dt == pytest.approx(2.3)
    changes = np.diff(speeds) / (0.5 * dt)
    # 0.15 / 0.5 s each of speeding up and of braking, to the last cycle
    np.testing.assert_allclose(changes, [1.0] * 75 + [0.0] * 425 + [-1.0] * 75, atol=1e-9)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("angle", [0.02, -0.02])
def test_a_move_over_the_end_of_the_counter_stays_in_its_range(direction, angle):
    near = round(math.copysign(2**31 - 1e6, direction * angle))
    rig = up(start_counts=near, direction=direction)
    rig.scale *= direction
    assert rig.drive.move_to(angle).accepted
    rig.run(2000, until=lambda s: rig.drive.at_target)
    assert rig.run(5).position == pytest.approx(angle, abs=1e-8)
    assert all(-(2**31) <= c.target_position < 2**31 for c in rig.commands)
    assert len({c.target_position > 0 for c in rig.commands}) == 2, "the end was passed"


@pytest.mark.parametrize("direction", [1, -1])
def test_counts_and_units_of_the_shaft_are_each_other_s_inverse(direction):
    p = DriveParameters(direction=direction)
    shaft = Shaft(p)
    shaft.read(AxisInputs(0, 0, 1000, 0, 0, 0), False)
    counts = direction * p.counts_per_turn * p.gear_ratio / math.tau
    shaft.read(AxisInputs(0, 0, 1000 + 5000, 7000, 123, 0), False)
    assert shaft.position == pytest.approx(5000 / counts)
    assert shaft.velocity == pytest.approx(7000 / counts)
    assert shaft.torque == pytest.approx(direction * 0.0123)
    assert shaft.raw_position(shaft.position) == 6000
    assert shaft.raw_position(0.0) == 1000
    assert shaft.raw_velocity(7000 / counts) == 7000
    assert shaft.raw_torque(direction * 0.0123) == 123
    assert shaft.raw_position(NAN) == 6000
    assert shaft.raw_velocity(NAN) == shaft.raw_torque(NAN) == 0
    shaft.read(AxisInputs(0, 0, 9000, 0, 0, 0), True)
    assert shaft.position == pytest.approx(5000 / counts), "the drive sets its counter"
    shaft.make_zero()
    shaft.read(AxisInputs(0, 0, 9100, 0, 0, 0), False)
    assert shaft.position == pytest.approx(100 / counts)


def test_mode_cannot_change_while_the_axis_turns():
    rig = up("velocity", 0.1)
    rig.run(100)
    assert "turns" in rig.drive.set_operation_mode("slip").reason
    assert rig.drive.set_operation_mode("velocity", 0.0).accepted
    rig.run(200)
    assert rig.drive.set_operation_mode("slip").accepted


@pytest.mark.parametrize("in_drive", [True, False])
def test_homing_makes_the_present_position_zero(in_drive):
    rig = up(home_in_drive=in_drive)
    rig.drive.move_to(0.7)
    rig.run(10_000, until=lambda s: rig.drive.at_target)
    assert rig.drive.home().accepted
    rig.run(30)
    assert rig.drive.mode == "position"
    assert rig.run(1).position == 0.0
    if in_drive:
        assert rig.counts == 0.0
    rig.drive.move_to(-0.3)
    rig.run(10_000, until=lambda s: rig.drive.at_target)
    assert rig.run(5).position == pytest.approx(-0.3, abs=2e-9)


def test_homing_that_is_not_answered_stops_the_axis():
    rig = up()
    rig.deaf = True
    rig.drive.home()
    sample = rig.run(400)
    assert sample.stop_reason == NO_ANSWER


def test_fault_needs_reset_and_then_enable():
    rig = up("velocity", 0.1)
    rig.run(100)
    rig.fault(0x7121)
    sample = rig.run(50)
    assert sample.stop_reason == RULES["drive_fault"].code
    assert sample.error_code == 0x7121
    assert "0x7121" in rig.drive.enable().reason
    assert rig.drive.reset_fault().accepted
    rig.run(20)
    assert rig.state is State.SWITCH_ON_DISABLED
    rig.run(200)
    assert rig.state is State.SWITCH_ON_DISABLED
    assert not rig.drive.reset_fault().accepted
    assert rig.drive.enable().accepted
    rig.run(20)
    assert rig.state is State.OPERATION_ENABLED


def test_fault_reset_is_a_rising_edge():
    rig = Rig()
    rig.fault()
    rig.run(10)
    rig.drive.reset_fault()
    rig.run(3)
    words = [c.control_word for c in rig.commands]
    edge = words.index(0x80)
    assert not words[edge - 1] & 0x80
    rig.run(10)
    assert rig.commands[-1].control_word == 0x00


def test_a_reset_that_is_not_answered_is_asked_for_a_second():
    rig = Rig()
    rig.fault()
    rig.run(10)
    rig.deaf = True
    assert rig.drive.reset_fault().accepted
    rig.run(400)
    words = [c.control_word & 0x80 for c in rig.commands[10:]]
    # 1 s of start_timeout, 250 cycles, from the cycle of the request on
    assert words[:250] == [0x80] * 250 and not any(words[253:])


def test_a_drive_that_leaves_operation_is_not_enabled_again():
    rig = up("velocity", 0.1)
    rig.run(50)
    rig.state = State.SWITCH_ON_DISABLED
    sample = rig.run(300)
    assert sample.stop_reason == LEFT_OPERATION
    assert rig.state in (State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON)


def test_a_drive_that_does_not_come_up_is_given_up():
    rig = Rig()
    rig.deaf = True
    rig.run(2)
    rig.drive.enable()
    sample = rig.run(400)
    assert sample.stop_reason == NO_ANSWER
    assert rig.commands[-1].control_word == 0


def test_quick_stop_and_disable_brake_a_turning_axis():
    for ask, code in (("quick_stop", QUICK_STOP), ("disable", 0)):
        rig = up("velocity", 0.1)
        rig.run(100)
        getattr(rig.drive, ask)()
        sample = rig.run(25)
        assert rig.velocity == 0.0
        assert sample.stop_reason == code
        assert 0x02 in [c.control_word for c in rig.commands]
        assert rig.run(200).state != State.OPERATION_ENABLED


def test_requests_take_effect_at_the_cycle_they_say():
    rig = Rig()
    rig.run(10)
    assert rig.drive.enable().cycle == 10
    rig.run(20)
    assert [c.control_word for c in rig.commands[:12]] == [0] * 10 + [6, 6]


def test_disabled_position_mode_does_not_move_when_enabled():
    rig = Rig()
    rig.run(2)
    assert rig.drive.set_operation_mode("position", 1.0).accepted
    rig.drive.enable()
    rig.run(100)
    assert rig.samples[-1].position == 0.0


def test_linear_axis_with_other_parameters():
    rig = up(
        axis="wheel", unit="m", output_per_turn=0.005, gear_ratio=10.0, direction=-1,
        rules=("inputs", "drive_fault"), speed_limit=0.05, move_speed=0.02, speed_trip=0.06,
        travel_min=0.0, travel_max=0.2, acceleration=0.1, standstill_speed=1e-5,
    )  # fmt: skip
    rig.drive.move_to(0.05)
    rig.run(5000, until=lambda s: rig.drive.at_target)
    assert rig.run(5).position == pytest.approx(0.05, abs=1e-8)
    assert "position is 0.3 m, must be within 0 .. 0.2" in rig.drive.move_to(0.3).reason


def test_a_cycle_is_cheap():
    rig = up("slip")
    rig.source, rig.reference = "slip", 0.1
    rig.plank(True)
    rig.run(5)
    inputs = [rig.image(n, n * 4_000_000) for n in range(rig.n, rig.n + 20000)]
    encoders, hub = rig._encoders, rig._hub
    samples = [
        (
            i,
            encoders._replace(cycle=i.cycle, stamp_ns=i.stamp_ns),
            hub._replace(stamp_ns=i.stamp_ns),
        )
        for i in inputs
    ]
    start = time.process_time()
    for i, e, h in samples:
        rig.drive.step(i, e, h, None)
    # 4.3 us on the machine where it was written; the bound only catches a change of kind
    assert (time.process_time() - start) / len(samples) < 40e-6


def test_the_bit_of_an_earlier_homing_does_not_count():
    """It may be set until the drive has answered the start of the new one, four cycles later."""
    sequence = HomingSequence(DriveParameters())
    sequence.start(0)
    attained = AxisInputs(0x0237 | HOMING_ATTAINED, CiaMode.HOMING, 0, 0, 0, 0)
    done = [sequence.step(attained, 4_000_000 * n)[1] for n in range(6)]
    assert done == [False] * 5 + [True]
    assert not sequence.running
