# SPDX-License-Identifier: Apache-2.0
"""Steady quantities against closed forms and the thesis's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.models.base import ContactGeometry
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_analysis.steady.stiffness import (
    fit_contact_length,
    friction,
    static_longitudinal_stiffness,
    vertical_stiffness,
)
from flatplank_analysis.steady.transmission import drive_state, efficiency, friction_torque
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable


def test_rolling_radius_by_motor_and_by_wheel(make_step):
    run = radius_of_run(make_step(0.0))
    assert run.radius == pytest.approx(0.31, rel=1e-9)
    assert run.source == "slip_control" and run.load == 3700.0


def test_rolling_radius_corrected_for_the_force(make_step):
    """A controller that holds 50 N lets the tire slip by 50 N / C_Fk."""
    table = make_step(0.0, measurement="free_rolling")
    slip = 50.0 / 9e4
    faster = table.with_columns(
        fx=np.full(len(table), 50.0), motor_velocity=table["motor_velocity"] * (1.0 + slip)
    )
    run = radius_of_run(faster)
    assert run.source == "controller"
    assert run.radius == pytest.approx(0.31 / (1.0 + slip))
    assert run.corrected(9e4) == pytest.approx(0.31, rel=1e-12)


def test_side_slip_shortens_the_travel(make_step):
    assert radius_of_run(make_step(0.0, alpha_deg=10.0)).radius == pytest.approx(
        0.31 * np.cos(np.radians(10.0))
    )


def test_flexplates_off_uses_the_wheel_encoder(make_step):
    table = make_step(0.0, measurement="free_rolling", r_e_source="flexplates_off")
    run = radius_of_run(table.with_columns(motor_velocity=0.0 * table["fx"]))
    assert run.source == "flexplates_off" and run.radius == pytest.approx(0.31)


def test_vertical_stiffness_loading_and_unloading():
    down = np.linspace(0.32, 0.28, 400)
    radius = np.concatenate([down, down[::-1]])
    force = np.concatenate([2.2e5 * (0.32 - down), 2.06e5 * (0.32 - down[::-1])])
    info = RunRecord(measurement="stiffness", pressure=2.5)
    found = vertical_stiffness(MeasurementTable({"loaded_radius": radius, "fz": force}, info))
    assert (found.loading, found.unloading) == pytest.approx((2.2e5, 2.06e5))
    assert found.mean == pytest.approx(2.13e5) and found.window == (0.285, 0.305)
    with pytest.raises(FlatplankError, match="window"):
        table = MeasurementTable({"loaded_radius": radius, "fz": force}, info)
        vertical_stiffness(table, (0.1, 0.2))


def test_the_window_ends_where_the_play_of_the_support_begins():
    """Up to 6000 N a tire of 2.5 bar does not reach 0.285 m; above 0.305 m the play bends Fz."""
    down = np.linspace(0.328, 0.2887, 500)
    force = 2.13e5 * np.maximum(0.305 - down, 0.0) + 1.7e5 * np.minimum(0.318 - down, 0.013)
    radius = np.concatenate([down, down[::-1]])
    columns = {"loaded_radius": radius, "fz": np.concatenate([force, force[::-1]])}
    found = vertical_stiffness(MeasurementTable(columns, RunRecord(measurement="stiffness")))
    assert found.window == (pytest.approx(0.2887), 0.305)
    assert found.mean == pytest.approx(2.13e5, rel=1e-3)


def test_static_longitudinal_stiffness_while_the_wheel_is_held(make_step):
    table = make_step(0.0)
    x = table["plank_position"]
    held = x < 0.005
    columns = {
        "wheel_angle": np.where(held, 0.0, table["wheel_angle"]),
        "fx": np.where(held, -1.6e5 * x, -800.0),
    }
    assert static_longitudinal_stiffness(table.with_columns(**columns)) == pytest.approx(1.6e5)
    assert np.isnan(static_longitudinal_stiffness(table))


def test_contact_length_of_the_thesis():
    """(7.20) with Table 7.2 gives these half lengths; the fit gives the coefficients back."""
    fz = np.array([1850.0, 3700.0, 5550.0])
    a = np.array([0.0496, 0.0708, 0.0872])
    fit = fit_contact_length(fz, a, np.full(3, 2.13e5), 0.318)
    assert (fit.q_ra1, fit.q_ra2) == pytest.approx((0.924, 0.120), abs=0.02)
    half = ContactGeometry(0.318, 2.13e5, q_ra1=fit.q_ra1, q_ra2=fit.q_ra2).half_length(fz, 250e3)
    np.testing.assert_allclose(half, a, atol=1e-4)


def test_one_footprint_fits_the_root_only():
    fit = fit_contact_length(np.array([3700.0]), np.array([0.0708]), np.array([2.13e5]), 0.318)
    half = 0.318 * fit.q_ra1 * np.sqrt(3700.0 / (2.13e5 * 0.318))
    assert fit.q_ra2 == 0.0 and half == pytest.approx(0.0708)


def test_friction_is_the_mean_over_conditions():
    assert friction(np.array([-3600.0, 3700.0]), np.array([3700.0, 3700.0])) == pytest.approx(
        0.9865, abs=1e-4
    )


def test_friction_torque_and_efficiency(make_step):
    speed = np.repeat(np.linspace(0.0, 150.0, 16), 50)
    torque = 1.5 + 0.002 * speed
    columns = {"time": 0.02 * np.arange(speed.size), "motor_velocity": speed}
    turn = MeasurementTable({**columns, "motor_torque": torque})
    curve = friction_torque([turn], bins=16)
    assert curve(75.0) == pytest.approx(1.65, abs=0.01)
    # what speeds the motor up is no friction
    ramp = np.interp(columns["time"], [0.0, 5.0, 7.0, 16.0], [50.0, 50.0, 150.0, 150.0])
    pushed = 1.5 + 0.002 * ramp + 0.1 * (np.gradient(ramp) > 0.0)
    faster = MeasurementTable({**columns, "motor_velocity": ramp, "motor_torque": pushed})
    assert friction_torque([faster])(100.0) == pytest.approx(1.7, abs=0.005)
    table = make_step(0.05)
    tire = table["fx"][-1] * 0.3 / 1425.04
    motor = 1.5 + 0.002 * table["motor_velocity"] + tire / 0.392
    driving = drive_state(table.with_columns(motor_torque=motor))
    assert efficiency([driving], [1], curve).value == pytest.approx(0.392, 2e-2)
    assert np.isnan(efficiency([drive_state(make_step(-0.05))], [1], curve).value)
