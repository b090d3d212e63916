# SPDX-License-Identifier: Apache-2.0
"""The tire as the bench shows it: where it slides, how fast it answers, what it can carry."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from plant_rig import Rig

from flatplank_sim.plant import PlantConfig, tires
from flatplank_validation.truth import truth_row, truth_table


@cache
def step_response(kappa: float, *over: tuple[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Road travel since the step [m] and fx [N] for a slip step after free rolling."""
    rig = Rig(over=dict(over))
    rig.plant.operator.axle_height(0.318 - 3700.0 / 2.13e5)
    rig.run(7.0)
    rig.enable()
    rig.roll(0.0, 0.6)
    rig.record = True
    start = rig.plant.truth.road_position
    rig.wheel_velocity(0.03092 * (1.0 + kappa) / 0.31088)
    rig.run(1.2 / 0.03092)
    return rig.column("road_position") - start, rig.column("fx")


def test_sliding_begins_at_the_trailing_edge_and_spreads_forward() -> None:
    rig = Rig()
    rig.load()
    rig.enable()
    shares = []
    for kappa in (0.01, 0.03, 0.06):
        rig.roll(kappa, 1.0)
        position, _, _, slides = rig.plant.bristles
        inside = slides[np.abs(position) < 0.999 * rig.plant.truth.contact_half_length]
        first = int(np.argmax(inside)) if inside.any() else len(inside)
        assert inside[first:].all() and not inside[:first].any()
        shares.append(inside.mean())
    assert 0.02 < shares[0] < shares[1] < shares[2] < 0.9


def test_the_distance_to_63_percent_falls_about_threefold_from_1_to_10_percent() -> None:
    distance = {}
    for kappa in (0.01, 0.10):
        x, fx = step_response(kappa)
        goal = fx[0] + 0.632 * (fx[-1] - fx[0])
        distance[kappa] = x[np.argmax(fx >= goal)]
    assert 2.4 < distance[0.01] / distance[0.10] < 3.6


@pytest.mark.parametrize("alpha_deg", [0.0, 3.0, 8.0])
def test_forces_stay_inside_the_friction_limit(alpha_deg: float) -> None:
    rig = Rig()
    rig.plant.operator.steer(math.radians(alpha_deg))
    rig.load()
    rig.enable()
    rig.record = True
    for kappa in (0.05, 0.4, -0.4):
        rig.roll(kappa, 0.35)
    force = np.hypot(rig.column("fx"), rig.column("fy"))
    limit = rig.column("friction") * rig.column("fz")
    assert (force <= limit * (1.0 + 1e-9)).all()
    assert force.max() > 0.97 * limit.max()


def test_deep_combined_sliding_opposes_the_slip_velocity() -> None:
    rig = Rig()
    alpha = math.radians(8.0)
    rig.plant.operator.steer(alpha)
    rig.load()
    rig.enable()
    rig.roll(0.8, 0.8)
    t = rig.plant.truth
    slip = (0.03092 * math.cos(alpha) * 0.0 + t.wheel_velocity * t.effective_rolling_radius
            - 0.03092 * math.cos(alpha), -0.03092 * math.sin(alpha))  # fmt: skip
    assert math.atan2(t.fy, t.fx) == pytest.approx(math.atan2(slip[1], slip[0]), abs=0.05)


def test_a_tire_at_standstill_has_a_stiffness_and_a_hysteresis() -> None:
    rig = Rig(over={"plank.slow_speed": 0.001})
    rig.load()
    operator = rig.plant.operator
    rig.record = True
    operator.plank(1, fast=False, stop_at=0.003)
    rig.until(lambda t: not operator.view.plank_moving and t.road_position > 0.0029)
    operator.plank(-1, fast=True, stop_at=0.0)
    rig.until(lambda t: not operator.view.plank_moving and t.road_position < 1e-4)
    # the wheel turns a little in the backlash of its gear
    x = rig.column("road_position") - 0.31088 * rig.column("wheel_angle")
    fx = rig.column("fx")
    early = x < 2e-4
    slope = -np.polyfit(x[: early.argmin()], fx[: early.argmin()], 1)[0]
    truth = truth_row(rig.config, rig.plant.truth.fz, 2.5)
    assert slope == pytest.approx(truth.standstill_stiffness_x, rel=0.03)
    assert abs(fx[-1]) > 2.0, "what slid does not come back"
    assert abs(fx[-1]) < 0.3 * abs(fx).max()


@pytest.mark.parametrize(
    "over",
    [
        (("solver.bristle_spacing", 0.00075),),
        (("solver.tire_step", 0.001), ("solver.drive_step", 0.00025)),
    ],
    ids=["bristles", "steps"],
)
def test_half_the_step_or_the_bristle_changes_fx_by_less_than_1_newton(over: tuple) -> None:
    _, coarse = step_response(0.05)
    _, fine = step_response(0.05, *over)
    assert np.abs(coarse - fine).max() < 1.0


def test_side_slip_camber_and_their_signs() -> None:
    rig = Rig()
    operator = rig.plant.operator
    operator.steer(math.radians(1.0))
    rig.load()
    rig.enable()
    rig.roll(0.0, 1.5)
    t = rig.plant.truth
    assert t.fy < -700.0
    assert t.mz > 5.0, "the self-aligning moment turns the wheel back"
    trail = t.mz / -t.fy
    assert 0.1 * t.contact_half_length < trail < 0.5 * t.contact_half_length
    operator.steer(0.0)
    operator.wheel_camber(math.radians(5.0))
    rig.run(5.0)
    rig.roll(0.0, 1.5)
    assert -800.0 < rig.plant.truth.fy < -100.0


def test_symmetric_unless_asymmetry_is_on() -> None:
    # kappa / (1 + kappa) is +-5.26 %
    x, drive = step_response(0.05 / 0.9)
    _, brake = step_response(-0.05)
    assert drive[-1] == pytest.approx(-brake[-1], rel=0.01)
    assert x[-1] > 1.0


@pytest.mark.parametrize("tire", tires())
def test_the_truth_table_of_every_tire(tire: str) -> None:
    config = PlantConfig.load(tire)
    low, high = truth_table(config, [0.5 * config.tire.nominal_load, config.tire.nominal_load], [
        config.tire.nominal_pressure_bar])  # fmt: skip
    assert low.slip_stiffness < high.slip_stiffness
    assert low.contact_half_length < high.contact_half_length
    assert low.effective_rolling_radius > high.effective_rolling_radius
    assert high.fx_10 < high.friction * high.fz
    assert high.distance_63 == pytest.approx(high.relaxation_length_x, rel=0.1)


def test_toyo_is_close_to_the_thesis() -> None:
    rows = truth_table(PlantConfig.load("toyo"), [1850.0, 3700.0, 5550.0], [2.5])
    assert [r.contact_half_length for r in rows] == pytest.approx(
        [0.0496, 0.0708, 0.0872], abs=1e-4
    )
    assert [r.effective_rolling_radius for r in rows] == pytest.approx(
        [0.31228, 0.31088, 0.31022], abs=1e-4
    )
    soft = truth_row(PlantConfig.load("toyo"), 3700.0, 2.0)
    assert soft.vertical_stiffness == pytest.approx(1.77e5, rel=0.002)
    assert 90e3 < rows[1].slip_stiffness < 102e3
    assert 0.45 < rows[1].relaxation_length_x < 0.63
