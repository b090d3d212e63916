# SPDX-License-Identifier: Apache-2.0
"""The emulated CiA 402 drives: state machine, modes, watchdog, faults, all five axes."""

from __future__ import annotations

import math

import pytest
from plant_rig import COUNTS, GEAR, TURN, Rig

SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP, FAULT = (
    0x40, 0x21, 0x23, 0x27, 0x07, 0x08,
)  # fmt: skip


def state(rig: Rig, axis: int = 0) -> int:
    word = rig.inputs.axes[axis].status_word
    return word & 0x4F if word & 0x4F in (0x40, 0x08, 0x0F, 0x00) else word & 0x6F


def send(rig: Rig, word: int, axis: int = 0, seconds: float = 0.04) -> int:
    rig.word[axis] = word
    rig.run(seconds)
    return state(rig, axis)


def test_the_state_machine_answers_the_control_word() -> None:
    rig = Rig()
    rig.mode[0] = 9
    assert send(rig, 0x00) == SWITCH_ON_DISABLED
    assert send(rig, 0x0F) == SWITCH_ON_DISABLED, "no short cut"
    assert send(rig, 0x06) == READY
    assert send(rig, 0x07) == SWITCHED_ON
    assert send(rig, 0x0F) == ENABLED
    assert send(rig, 0x07) == SWITCHED_ON
    assert send(rig, 0x0F) == ENABLED
    assert send(rig, 0x06) == READY
    assert send(rig, 0x0F, seconds=0.1) == ENABLED
    assert send(rig, 0x0B, seconds=0.5) == SWITCH_ON_DISABLED, "quick stop, then off"
    assert send(rig, 0x0F) == SWITCH_ON_DISABLED


def test_quick_stop_stops_within_100_ms() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.run(1.0)
    assert rig.plant.truth.wheel_velocity > 0.099
    rig.word[0] = 0x0B
    rig.run(0.1)
    assert abs(rig.plant.truth.wheel_velocity) < 1e-4


def test_a_drive_without_fresh_commands_stops_within_100_ms_and_faults() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.run(1.0)
    rig.run(0.1, send=False)
    truth = rig.plant.truth
    assert truth.motor_velocity == 0.0 and abs(truth.gear_gap) < math.radians(15.0)
    assert abs(truth.wheel_velocity) < 0.02, "the wheel swings in the gap of the gear"
    rig.run(0.1, send=False)
    assert abs(rig.plant.truth.wheel_velocity) < 1e-6
    assert state(rig) == FAULT
    assert rig.inputs.axes[0].error_code == 0x7500
    rig.run(0.2)
    assert state(rig) == FAULT, "fresh commands alone do not start it again"
    assert rig.plant.truth.wheel_velocity == pytest.approx(0.0, abs=1e-6)
    send(rig, 0x00)
    assert send(rig, 0x80) == SWITCH_ON_DISABLED


def test_an_injected_fault_stays_until_its_cause_is_gone_and_a_reset_edge() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.run(0.5)
    rig.plant.inject_fault("wheel", 0x2310)
    rig.run(0.1)
    assert state(rig) == FAULT
    assert rig.inputs.axes[0].error_code == 0x2310
    assert abs(rig.plant.truth.wheel_velocity) < 1e-4
    send(rig, 0x00)
    assert send(rig, 0x80) == FAULT, "the cause is still there"
    rig.plant.inject_fault("wheel", 0)
    assert send(rig, 0x80) == FAULT, "bit 7 counts on its rising edge"
    send(rig, 0x00)
    assert send(rig, 0x80) == SWITCH_ON_DISABLED
    with pytest.raises(ValueError, match="has no drive"):
        rig.plant.inject_fault("steer")


def test_a_stuck_axis_runs_into_its_limit_and_gives_up() -> None:
    rig = Rig()
    rig.enable()
    rig.plant.stick("wheel")
    rig.wheel_velocity(0.1)
    rig.run(0.2)
    assert rig.inputs.axes[0].status_word & 0x0800, "internal limit"
    assert rig.plant.truth.motor_velocity == 0.0
    rig.run(1.0)
    assert state(rig) == FAULT
    assert rig.inputs.axes[0].error_code == 0x7121


def test_profile_velocity_ramps_and_reports_the_target() -> None:
    rig = Rig()
    rig.enable(mode=3)
    rig.wheel_velocity(0.2)
    rig.mode[0] = 3
    rig.run(0.2)
    acceleration = rig.config.servos["wheel"].acceleration
    assert rig.plant.truth.motor_velocity < acceleration * 0.2
    rig.run(1.0)
    assert rig.plant.truth.wheel_velocity == pytest.approx(0.2, rel=1e-3)
    assert rig.inputs.axes[0].status_word & 0x0400
    assert rig.inputs.axes[0].mode_display == 3


def test_profile_position_goes_there_with_hardly_an_overshoot() -> None:
    rig = Rig()
    rig.enable(mode=1)
    rig.mode[0] = 1
    turns = 100.0
    rig.target[0] = (round(turns * COUNTS), 0, 0)
    rig.record = True
    rig.word[0] = 0x1F
    rig.run(6.0)
    assert rig.plant.truth.motor_angle == pytest.approx(turns * TURN, abs=0.05)
    assert rig.column("motor_angle").max() < turns * TURN + 2.0
    assert rig.inputs.axes[0].status_word & 0x0400
    assert rig.plant.truth.wheel_angle == pytest.approx(turns * TURN / GEAR, abs=5e-4)


def test_cyclic_position_follows_a_moving_target_over_the_wrap() -> None:
    rig = Rig()
    rig.enable(mode=8)
    rig.mode[0] = 8
    speed = 300.0 * COUNTS / TURN
    for n in range(4000):
        position = round(n * speed * 0.004)
        rig.target[0] = ((position + 2**31) % 2**32 - 2**31, 0, 0)
        rig.run(0.004)
    assert rig.plant.truth.motor_angle == pytest.approx(4000 * 0.004 * 300.0, abs=10.0)
    assert rig.plant.truth.motor_angle > 256 * TURN


def test_homing_makes_here_zero() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.run(1.0)
    rig.wheel_velocity(0.0)
    rig.run(0.5)
    assert abs(rig.inputs.axes[0].position) > COUNTS
    rig.mode[0], rig.word[0] = 6, 0x1F
    rig.run(0.1)
    assert abs(rig.inputs.axes[0].position) < COUNTS / 100
    assert rig.inputs.axes[0].status_word & 0x1000


def test_no_jump_when_enabled_with_old_set_points() -> None:
    rig = Rig()
    rig.mode[0] = 9
    rig.target[0] = (0, 0, 0)
    rig.record = True
    rig.enable()
    rig.run(0.5)
    assert abs(rig.column("motor_angle")).max() < 1e-3


@pytest.mark.parametrize(
    ("axis", "index", "read", "gain"),
    [
        ("plank", 1, lambda t: t.plank_position, 0.0005),
        ("steer", 2, lambda t: t.alpha, 0.0062832),
        ("vertical", 3, lambda t: t.axle_height, 0.0002),
        ("camber", 4, lambda t: t.gamma, 0.0062832),
    ],
)
def test_the_other_axes_are_driven_when_listed(axis: str, index: int, read, gain: float) -> None:
    rig = Rig(over={"driven_axes": ["wheel", axis]})
    before = read(rig.plant.truth)
    rig.enable(axis)
    speed = 20.0
    rig.target[index] = (0, round(speed / TURN * COUNTS), 0)
    rig.run(1.0)
    moved = read(rig.plant.truth) - before
    assert moved == pytest.approx(speed / TURN * gain * 1.0, rel=0.05)
    assert rig.inputs.axes[index].velocity == pytest.approx(speed / TURN * COUNTS, rel=0.01)
    assert rig.inputs.axes[3 - index % 2].status_word == 0 or index == 3 - index % 2
    rig.plant.operator.emergency_stop()
    rig.run(0.3)
    assert rig.inputs.axes[index].velocity == 0
    assert state(rig, index) == SWITCH_ON_DISABLED


def test_a_driven_plank_feels_the_tire() -> None:
    rig = Rig(over={"driven_axes": ["wheel", "plank"]})
    rig.load()
    rig.enable()
    rig.enable("plank")
    rig.target[1] = (0, round(0.03 / 0.0005 * COUNTS), 0)
    rig.wheel_velocity(0.03 / 0.31088)
    rig.run(15.0)
    free = rig.inputs.axes[1].torque
    rig.wheel_velocity(0.03 * 0.9 / 0.31088)
    rig.run(15.0)
    assert rig.plant.truth.fx < -3000.0
    push = -rig.plant.truth.fx * 0.0005 / (2.0 * math.pi)
    assert (rig.inputs.axes[1].torque - free) * 1e-4 == pytest.approx(push, rel=0.05)
