# SPDX-License-Identifier: Apache-2.0
"""The operator's switches and handwheels, and a whole sequence of his."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plant_rig import Rig

from flatplank_hw.bus.image import Digital


def test_the_plank_starts_stops_and_ends_at_its_switches() -> None:
    rig = Rig()
    operator = rig.plant.operator
    rig.record = True
    operator.plank(1, fast=True)
    rig.run(0.5)
    assert rig.plant.truth.road_velocity == pytest.approx(0.03092)
    moving = rig.column("road_velocity") > 0.0
    assert np.diff(rig.column("road_velocity"))[1:30].max() == pytest.approx(
        0.206 * 0.004, rel=0.01
    )
    assert moving.any()
    operator.plank_stop_at(0.3)
    rig.run(12.0)
    assert rig.plant.truth.plank_position == pytest.approx(0.3, abs=1e-4)
    operator.plank(-1, fast=True)
    rig.run(14.0)
    assert rig.inputs.digital & Digital.LIMIT_REAR
    assert rig.plant.truth.plank_position == pytest.approx(-0.01, abs=0.004)
    operator.plank(1, fast=False)
    rig.run(2.0)
    assert rig.plant.truth.road_velocity == pytest.approx(0.0015)
    rig.plant.operator.plank(1, fast=True)
    rig.run(160.0)
    assert rig.inputs.digital & Digital.LIMIT_FRONT
    assert rig.plant.truth.road_velocity == 0.0
    assert rig.plant.truth.plank_position == pytest.approx(4.22, abs=0.003)


def test_the_trigger_comes_at_its_place_and_counts_the_run() -> None:
    rig = Rig()
    rig.record = True
    rig.plant.operator.plank(1, fast=True, stop_at=0.2)
    rig.run(9.0)
    on = np.array([bool(r.digital & Digital.TRIGGER) for r in rig.raw])
    x = rig.column("plank_position")
    assert x[on].min() == pytest.approx(0.02, abs=2e-4)
    assert x[on].max() == pytest.approx(0.05, abs=2e-4)
    assert rig.plant.operator.view.runs == 1
    assert rig.inputs.plank_counts == pytest.approx(0.2 / (2 * math.pi * 0.05) * 20000, abs=8)


def test_the_emergency_stop_stops_the_plank_at_once_and_not_the_wheel() -> None:
    rig = Rig()
    rig.enable()
    rig.wheel_velocity(0.1)
    rig.plant.operator.plank(1, fast=True)
    rig.run(2.0)
    rig.plant.operator.emergency_stop()
    rig.run(0.06)
    assert rig.plant.truth.road_velocity == 0.0
    assert not rig.inputs.digital & Digital.EMERGENCY_STOP_OK
    rig.run(0.3)
    assert rig.plant.truth.wheel_velocity == pytest.approx(0.1, rel=1e-3)
    rig.plant.operator.emergency_stop(False)
    rig.run(0.5)
    assert rig.inputs.digital & Digital.EMERGENCY_STOP_OK
    assert rig.plant.truth.road_velocity == 0.0, "released, nothing moves by itself"


def test_the_operators_sequence_unload_return_turn_reload_run() -> None:
    rig = Rig(over={"plank.return_speed": 0.3})
    operator = rig.plant.operator
    forces = []
    for start in (0.0, 2.0 * math.pi / 3.0):
        operator.unload()
        rig.until(lambda t: operator.view.at_target)
        operator.plank(-1, fast=True, stop_at=0.0)
        rig.until(lambda t: t.plank_position < 1e-4 and not operator.view.plank_moving)
        rig.enable()
        goal = start - rig.plant.truth.wheel_angle % (2.0 * math.pi)
        rig.wheel_velocity(0.2)
        rig.run((goal % (2.0 * math.pi)) / 0.2)
        rig.wheel_velocity(0.0)
        rig.run(0.5)
        assert rig.plant.truth.fz == 0.0
        operator.load_to(3700.0)
        rig.until(lambda t: operator.view.load_reached)
        assert rig.plant.truth.fz == pytest.approx(3700.0, abs=1.0)
        assert rig.plant.truth.fx == 0.0, "a reloaded tire is straight"
        rig.roll(0.05, 1.6)
        forces.append(rig.plant.truth.fx)
        operator.plank(0)
        rig.wheel_velocity(0.0)
        rig.run(1.0)
    assert operator.view.runs == 2
    assert forces[0] == pytest.approx(forces[1], abs=3.0)


def test_the_operator_refuses_what_cannot_be() -> None:
    operator = Rig().plant.operator
    before = operator.view
    for wrong in (
        lambda: operator.plank(2),
        lambda: operator.plank(1, stop_at=9.0),
        lambda: operator.axle_height(math.nan),
        lambda: operator.load_to(-1.0),
        lambda: operator.steer(2.0),
        lambda: operator.wheel_camber(math.inf),
        lambda: operator.pressure(30.0),
    ):
        with pytest.raises(ValueError, match=r"must be within|not -1|must be finite"):
            wrong()
    assert operator.view == before


def test_load_follows_height_and_pressure() -> None:
    rig = Rig()
    rig.plant.operator.axle_height(0.30)
    rig.run(6.0)
    assert rig.plant.truth.fz == pytest.approx(0.018 * 2.13e5, rel=1e-6)
    rig.plant.operator.pressure(2.0)
    rig.run(0.1)
    assert rig.plant.truth.fz == pytest.approx(0.018 * 1.77e5, rel=2e-3)


def test_a_standing_tire_has_a_lateral_stiffness() -> None:
    rig = Rig()
    rig.load()
    rig.plant.operator.lateral(0.001)
    rig.run(1.0)
    t = rig.plant.truth
    stuck = 1.0 / (1.0 / 1.1e5 + 1.0 / (2 * 0.0708 * 5.8e6))
    assert -t.fy / 0.001 == pytest.approx(stuck, rel=0.05)
    rig.plant.operator.lateral(0.0)
    rig.run(1.0)
    assert abs(rig.plant.truth.fy) < 20.0


def test_a_cleat_lifts_the_tire_and_pushes_it_back_and_forth() -> None:
    rig = Rig(over={"cleat": {"height": 0.003, "position": 0.5}})
    rig.load()
    rig.enable()
    rig.record = True
    rig.roll(0.0, 0.8)
    x, fx, fz = rig.column("road_position"), rig.column("fx"), rig.column("fz")
    assert fz.max() == pytest.approx(3700.0 + 0.003 * 2.13e5, rel=0.01)
    assert x[fz.argmax()] == pytest.approx(0.5, abs=0.005)
    near = (x > 0.4) & (x < 0.6)
    assert x[near][fx[near].argmin()] < 0.5 < x[near][fx[near].argmax()]
    assert fx[near].min() < -100.0
