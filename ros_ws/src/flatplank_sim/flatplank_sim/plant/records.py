# SPDX-License-Identifier: Apache-2.0
"""Builds the numeric records of the kernels from the configuration."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flatplank_hw.bus.image import AXES
from flatplank_sim.plant import layout
from flatplank_sim.plant.config import PlantConfig, ServoConfig, TireConfig, cleat_heights
from flatplank_sim.plant.defects.base import Site

TURN = 2.0 * math.pi
RING_MARGIN = 2.6
"""smallest length of the ring of bristles over the contact length at nominal load [-]"""


class Records(NamedTuple):
    """Records that are constant during a run."""

    machine: np.ndarray
    tire: np.ndarray
    drives: np.ndarray
    curve: np.ndarray
    road_map: np.ndarray
    mix: np.ndarray
    drift: np.ndarray


def tire_record(t: TireConfig, spacing: float) -> np.ndarray:
    """Make the record of the tire, with `spacing` of the bristles [m]."""
    r = np.zeros(1, layout.TIRE)
    r["r0"], r["fz0"], r["p0"] = t.free_radius, t.nominal_load, t.nominal_pressure_bar
    r["cz"], r["cz_p"] = t.vertical_stiffness, t.vertical_stiffness_pressure
    r["a"], r["a_rho"] = t.contact_half_length, t.contact_half_length_deflection
    r["cpx"], r["cpy"] = t.tread_stiffness_x, t.tread_stiffness_y
    r["cp_p"] = t.tread_stiffness_pressure
    r["cx"], r["cx_f"] = t.carcass_stiffness_x, t.carcass_stiffness_x_load
    r["cx_p"] = t.carcass_stiffness_x_pressure
    r["cy"], r["cy_f"] = t.carcass_stiffness_y, t.carcass_stiffness_y_load
    r["cy_p"] = t.carcass_stiffness_y_pressure
    r["mu"], r["mu_f"], r["mu_p"] = t.friction, t.friction_load, t.friction_pressure
    r["re_drop"], r["re_half"] = t.rolling_radius_drop, t.rolling_radius_half_deflection
    r["rolling"], r["camber"] = t.rolling_resistance, t.camber_factor
    r["creep_time"] = 1.0
    r["spacing"] = spacing
    # a power of two, so that a bit mask gives the index in the ring
    bristles = max(RING_MARGIN * 2.0 * t.contact_half_length / spacing, 16.0)
    r["ring"] = 2 ** math.ceil(math.log2(bristles))
    return r


def machine_record(c: PlantConfig, dt: float) -> np.ndarray:
    """Make the record of the machine without defects; dt: period of the samples [s]."""
    m = np.zeros(1, layout.MACHINE)
    p, x, w, h, e, s = c.plank, c.axes, c.wheel_drive, c.hub, c.encoders, c.solver
    m["slow"], m["fast"], m["return_speed"] = p.slow_speed, p.fast_speed, p.return_speed
    m["acceleration"], m["estop_deceleration"] = p.acceleration, p.estop_deceleration
    m["road_length"], m["switch_travel"] = p.road_length, p.rear_limit
    m["pinion_radius"] = p.pinion_pitch_radius
    m["trigger_at"], m["trigger_length"] = p.trigger_position, p.trigger_length
    m["vertical_speed"], m["load_gain"] = x.vertical_speed, x.load_gain
    m["height_min"], m["height_max"] = x.lowest_axle, x.highest_axle
    m["steer_speed"] = math.radians(x.steer_speed_deg)
    m["camber_speed"] = math.radians(x.camber_speed_deg)
    m["gear"], m["j_motor"], m["j_wheel"] = w.gear_ratio, w.motor_inertia, w.wheel_inertia
    m["j_free"], m["efficiency"] = w.free_wheel_inertia, w.efficiency
    # spring and damper of the thesis are at the motor, before the gear loss
    m["k_spring"], m["d_spring"] = w.efficiency * w.stiffness, w.efficiency * w.damping
    m["backlash"], m["lock_ratio"] = math.radians(w.backlash_deg), w.lock_ratio
    m["bearing_torque"], m["rolling_speed"] = w.bearing_torque, 1e-4
    m["estop_wheel"] = int(w.estop_cuts_drive)
    for name in ("k_fx1", "k_fx2", "k_fy", "k_fz1", "k_fz2", "amplification", "gravity"):
        m[name] = getattr(h, name)
    m["et_value"], m["adapter"] = h.et_value, h.adapter_thickness
    m["volts_max"], m["spin_moment"] = h.saturation_volts, float(h.spin_axis_moment)
    m["lvdt_slope"], m["lvdt_zero"] = h.lvdt_gain, h.lvdt_offset
    m["pinion_counts"], m["wheel_counts"] = e.plank_counts_per_turn, e.wheel_counts_per_turn
    m["steer_counts"], m["camber_counts"] = e.steer_counts_per_turn, e.camber_counts_per_turn
    m["road_resolution"] = TURN * e.road_encoder_radius / e.road_counts_per_turn
    m["road_encoder"] = int(e.road_encoder_fitted)
    m["steer_on_hub"] = int(e.steer_on_hub)
    m["mesh_pitch"], m["wander_period"], m["gap_damping"] = 1.0, 1.0, 5e3
    m["scatter_pitch"] = 1.0
    m["steer_damping"] = 500.0
    m["support_to"] = 1.0
    m["dt"] = dt
    m["tire_steps"] = steps = max(math.ceil(dt / s.tire_step - 1e-9), 1)
    m["drive_steps"] = max(math.ceil(dt / steps / s.drive_step - 1e-9), 1)
    return m


def servo_record(r: np.ndarray, s: ServoConfig, watchdog: int) -> None:
    """Fill the record of one drive; `r` is a view of one element, `watchdog` is in cycles."""
    for name in (
        "torque_limit", "velocity_limit", "profile_velocity", "acceleration", "torque_slope",
        "position_gain", "inertia", "friction", "blocked_time", "velocity_window", "start_delay",
    ):  # fmt: skip
        r[name] = getattr(s, name)
    r["counts"] = s.counts_per_turn
    r["quick_deceleration"] = s.quick_stop_deceleration
    r["gain"] = s.inertia * TURN * s.velocity_bandwidth_hz
    r["integral_gain"] = r["gain"] * TURN * s.velocity_integral_hz
    r["window"] = s.window_counts * TURN / s.counts_per_turn
    r["scale"] = s.output_per_turn / TURN
    r["watchdog"], r["fitted"] = watchdog, 1


def build_records(c: PlantConfig, dt: float) -> Records:
    """Make the constant records, with all defects; dt: period of the samples [s]."""
    drives = np.zeros(len(AXES), layout.DRIVE)
    for axis in c.driven_axes:
        k = AXES.index(axis)
        servo_record(drives[k : k + 1], c.servos[axis], c.watchdog_cycles)
    rows = int((c.plank.road_length + 3.0 * layout.MAP_START) / layout.MAP_STEP)
    road_map = np.zeros((rows, 4))
    road_map[:, 0] = 1.0
    w = c.wheel_drive
    curve = np.array([w.friction_speed, w.friction_torque]).T.copy()
    r = Records(
        machine_record(c, dt), tire_record(c.tire, c.solver.bristle_spacing), drives, curve,
        road_map, np.eye(5), np.zeros((7, 2)),
    )  # fmt: skip
    site = Site(r.machine, r.tire, drives[:1], r.road_map, r.mix, r.drift)
    if c.cleat.height:
        x = site.positions() + c.plank.trigger_position
        site.road_map[:, 2] += cleat_heights(c, x, c.cleat.height)
        site.use_map()
    for defect in c.defects.values():
        defect.install(site)
    return r


def initial_state(c: PlantConfig, r: Records) -> dict[str, np.ndarray]:
    """Make the variable records: unloaded, at rest, plank in its start position."""
    s = np.zeros(1, layout.MACHINE_STATE)
    height = c.tire.free_radius + c.axes.clearance
    s["height"], s["pressure"], s["joined"] = height, c.tire.nominal_pressure_bar, 1.0
    s["armed"] = 1
    s["w_y"] = s["y_road"] = 0.5 * r.machine["support_gap_y"]
    s["y_road"] += r.machine["wander"] * np.sin(r.machine["wander_phase"])
    s["alpha"] = r.machine["steer_error"]
    ts = np.zeros(1, layout.TIRE_STATE)
    ts["last"], ts["re"] = -1, c.tire.free_radius
    op = np.zeros(1, layout.OPERATOR)
    op["height"], op["pressure"], op["flexplates"] = height, c.tire.nominal_pressure_bar, 1
    return {
        "state": s,
        "tire_state": ts,
        "operator": op,
        "drive_state": np.zeros(len(AXES), layout.DRIVE_STATE),
        "bristles": np.zeros((5, int(r.tire["ring"][0]))),
    }
