# SPDX-License-Identifier: Apache-2.0
"""The wheel rotation actuator: self-locking, torque over slip, backlash, flexplates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plant_rig import GEAR, QUIET, Rig, wrap_free

from flatplank_sim.plant import PlantConfig


def test_a_resting_motor_locks_the_wheel() -> None:
    for enabled in (False, True):
        rig = Rig()
        rig.load()
        if enabled:
            rig.enable()
            rig.wheel_velocity(0.0)
        rig.plant.operator.plank(1, fast=True, stop_at=0.05)
        rig.run(4.0)
        t = rig.plant.truth
        assert t.fx < -3000.0, "the road drags the locked tire"
        # the gear's gap is all that the wheel can turn
        assert abs(t.wheel_angle) < math.radians(31.0) / GEAR
        assert t.motor_velocity == 0.0 or abs(t.motor_velocity) < 1e-6


def steady_torque(kappa: float, fz: float) -> float:
    rig = Rig(over={"plank.fast_speed": 0.03092})
    rig.plant.operator.axle_height(0.318 - fz / 2.13e5)
    rig.run(8.0)
    rig.enable()
    rig.roll(0.0, 0.2)
    rig.roll(kappa, 1.3)
    return rig.plant.truth.motor_torque


def test_motor_torque_over_slip_has_the_shape_of_figure_5_13() -> None:
    slips = (-0.1, -0.05, -0.01, 0.01, 0.05, 0.1)
    torque = {fz: [steady_torque(k, fz) for k in slips] for fz in (1850.0, 5550.0)}
    friction = PlantConfig.load().wheel_drive.friction_torque
    for values in torque.values():
        assert all(min(friction) - 0.05 < v < max(friction) + 0.05 for v in values[:3]), (
            "braking needs no more than the friction torque"
        )
        assert values[3] < values[4] < values[5]
    low, high = np.array(torque[1850.0]), np.array(torque[5550.0])
    assert np.abs(low - high)[:3].max() < 0.05, "and it does not depend on the load"
    assert (high - low)[4:].min() > 1.0
    rig_torque = 5550.0 * 1.0289 * (0.318 - 5550.0 / 2.13e5) / 0.392 / GEAR
    assert high[5] - 0.752 == pytest.approx(rig_torque, rel=0.03)


def test_after_a_torque_reversal_the_motor_turns_and_the_wheel_waits() -> None:
    rig = Rig()
    rig.load()
    rig.enable()
    rig.roll(0.02, 0.4)
    driving = rig.plant.truth.gear_gap
    rig.roll(-0.02, 0.4)
    braking = rig.plant.truth.gear_gap
    gap = math.radians(30.0)
    assert driving - braking == pytest.approx(gap, rel=0.02)
    assert gap / GEAR * 0.3 == pytest.approx(0.11e-3, rel=0.02)


def test_flexplates_off_the_wheel_rolls_freely() -> None:
    rig = Rig()
    rig.plant.operator.flexplates(False)
    rig.load()
    rig.record = True
    rig.plant.operator.plank(1, fast=True)
    rig.until_position(2.5)
    x, theta = rig.column("road_position"), rig.column("wheel_angle")
    k = x > 1.0
    radius = np.polyfit(theta[k], x[k], 1)[0]
    truth = rig.plant.truth
    drag = truth.fx / 95e3
    assert -80.0 < truth.fx < 0.0, "only rolling resistance"
    assert radius == pytest.approx(truth.effective_rolling_radius * (1.0 - drag), rel=2e-4)
    assert radius == pytest.approx(truth.effective_rolling_radius, rel=1e-3)
    assert rig.plant.truth.motor_angle == 0.0
    with pytest.raises(ValueError, match="must rest"):
        rig.plant.operator.flexplates(True)
    rig.plant.operator.plank(0)
    rig.run(1.0)
    rig.plant.operator.flexplates(True)
    assert rig.plant.truth.fx != 0.0


def test_unloaded_the_motor_delivers_the_friction_torque() -> None:
    rig = Rig()
    rig.enable()
    for omega in (0.03, 0.1, 0.2):
        rig.wheel_velocity(omega)
        rig.run(2.0)
        t = rig.plant.truth
        w = rig.config.wheel_drive
        curve = np.interp(omega * GEAR, w.friction_speed, w.friction_torque)
        assert t.motor_torque == pytest.approx(curve + w.bearing_torque / 0.392 / GEAR, abs=0.02)
        assert t.wheel_velocity == pytest.approx(omega, rel=1e-4)


def test_half_a_motor_torque_below_friction_does_not_move_the_wheel() -> None:
    rig = Rig()
    rig.enable(mode=10)
    rig.wheel_torque(0.7)
    rig.run(1.0)
    assert rig.plant.truth.wheel_angle == 0.0
    rig.wheel_torque(1.2)
    rig.run(1.0)
    assert rig.plant.truth.motor_velocity > 10.0


def test_motor_and_wheel_encoders_agree_with_the_truth() -> None:
    rig = Rig()
    rig.enable()
    rig.record = True
    rig.wheel_velocity(0.5)
    rig.run(8.0)
    motor = wrap_free(np.array([r.axes[0].position for r in rig.raw])) / 2**23 * 2.0 * math.pi
    truth = rig.column("motor_angle")
    assert np.abs(motor - (truth - truth[0])).max() < 1e-5
    wheel = np.array([r.wheel_counts for r in rig.raw]) / 20000.0 * 2.0 * math.pi
    assert np.abs(wheel - rig.column("wheel_angle")).max() < 2.0 * math.pi / 20000.0
    assert motor[-1] > 2.0 * math.pi * 256.0, "the motor position has wrapped"


def test_a_delay_of_commands_is_counted_in_cycles() -> None:
    for delay in (0, 2, 5):
        rig = Rig(over={"command_delay_cycles": delay, **QUIET})
        rig.enable(mode=10)
        rig.run(0.1)
        rig.record = True
        rig.wheel_torque(3.0)
        rig.run(0.1)
        moved = int(np.argmax(rig.column("motor_torque") > 2.9))
        assert moved == delay
