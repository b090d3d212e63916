# SPDX-License-Identifier: Apache-2.0
"""The thesis's nonlinear simulation (5.15)-(5.21)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_data.machine import FRICTION_SPEED, FRICTION_TORQUE
from flatplank_hw.hub import HubParameters
from flatplank_sim.plant import PlantConfig
from flatplank_validation.free_rolling.nonlinear import (
    FIGURE_5_11,
    Nonlinear,
    friction_table,
    settling_distance,
    simulate,
)

P = FreeRollingParameters(automatic=False)


@pytest.fixture(scope="module")
def run():
    return simulate(Nonlinear(), P)


def test_the_friction_of_the_machine_is_that_of_the_measured_settling_distance(run):
    """Figures 5.18 and 5.20: 1.54 m measured, and simulated with the measured friction."""
    assert settling_distance(run.position, run.force) == pytest.approx(1.54, abs=0.005)


@pytest.mark.parametrize("table", [friction_table(FIGURE_5_11), ((0.0, FIGURE_5_11),)])
def test_the_friction_of_figure_5_11_is_that_of_the_first_simulation(table):
    """1.41 m by the text of section 5.5, whatever the friction is at other speeds."""
    first = simulate(Nonlinear(friction=table), P)
    assert settling_distance(first.position, first.force) == pytest.approx(1.41, abs=0.005)


def test_one_table_of_friction():
    """Plant, hub and design read the same numbers."""
    plant, hub = PlantConfig.load().wheel_drive, HubParameters()
    assert plant.friction_speed == hub.friction_speed == FRICTION_SPEED
    assert plant.friction_torque == hub.friction_torque == FRICTION_TORQUE
    assert Nonlinear().friction == tuple(zip(FRICTION_SPEED, FRICTION_TORQUE, strict=True))


def test_steady_force_and_engaged_gears(run):
    late = run.position > 3.0
    assert np.abs(run.force[late] / 50.0 - 1.0).max() < 0.005
    engaged = run.position > 0.03
    assert run.gear_angle[engaged].min() > math.radians(15.0)
    assert run.gear_angle[0] == 0.0


def test_estimator_on_an_exponential():
    x = np.linspace(0.0, 4.1, 4000)
    noise = np.random.default_rng(1).normal(0.0, 5.0, x.size)
    y = 120.0 * np.exp(-2.5 * x) + 50.0
    wanted = math.log(120.0 / 2.5) / 2.5
    assert settling_distance(x, y) == pytest.approx(wanted, abs=1e-3)
    assert settling_distance(x, y + noise) == pytest.approx(wanted, abs=0.05)
    assert math.isnan(settling_distance(x, y + 10.0))
    assert settling_distance(x, np.full_like(x, 50.0)) == 0.0


def test_a_measured_road_speed_takes_the_place_of_the_constant_one():
    constant = Nonlinear().actuator.speed
    usual = simulate(Nonlinear(), P, distance=0.1)
    same = simulate(Nonlinear(), P, distance=0.1, speed=lambda _: constant)
    half = simulate(Nonlinear(), P, distance=0.1, speed=lambda _: 0.5 * constant)
    assert np.array_equal(usual.force, same.force)
    assert half.time[-1] == pytest.approx(2.0 * usual.time[-1], rel=0.05)
