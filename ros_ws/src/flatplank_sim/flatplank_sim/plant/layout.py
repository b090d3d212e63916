# SPDX-License-Identifier: Apache-2.0
"""The records that the compiled kernels read and write, SI units.

A structured array of one element is one bench; a campaign uses the same records, one element per
run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


def _record(floats: str, wholes: str = "") -> np.dtype:
    return np.dtype([(n, "f8") for n in floats.split()] + [(n, "i8") for n in wholes.split()])


TIRE = _record(
    # nominal values with their exponents over load (f) and pressure (p)
    "r0 fz0 p0 cz cz_p a a_rho cpx cpy cp_p cx cx_f cx_p cy cy_f cy_p mu mu_f mu_p "
    "re_drop re_half camber rolling "
    # defects that belong to the tire
    "brake_friction softening creep creep_time ply_steer conicity "
    # distance between bristles [m]
    "spacing",
    # bristles in the ring
    "ring",
)

TIRE_STATE = _record("q ux uy ucx fx fy mz gx gy a friction re cz slide_share", "first last")

MACHINE = _record(
    # plank
    "slow fast return_speed acceleration estop_deceleration road_length switch_travel "
    "pinion_radius trigger_at trigger_length "
    # the operator's axes
    "vertical_speed load_gain steer_speed camber_speed height_min height_max "
    # wheel drive
    "gear j_motor j_wheel j_free k_spring d_spring backlash efficiency lock_ratio "
    "bearing_torque rolling_speed "
    # hub (Appendix A), amplifier, LVDT
    "et_value adapter k_fx1 k_fx2 k_fy k_fz1 k_fz2 amplification gravity volts_max adc_step "
    "lvdt_slope lvdt_zero spin_moment "
    # encoders [counts per turn, m per count]
    "pinion_counts wheel_counts steer_counts camber_counts road_resolution "
    # noise
    "noise_bridge noise_lvdt noise_torque hum hum_frequency "
    # kinematic chain
    "road_gap road_friction rack_gap rack_friction gap_damping mesh_tooth mesh_pitch mesh_turn "
    "mesh_phase speed_error scale_error droop scatter_travel scatter_pitch scatter_delay "
    "weld_gap weld_hold weld_spread weld_speed weld_seen "
    "support_gap_y support_gap_z support_from support_to support_friction "
    "wander wander_period wander_phase "
    "steer_error steer_play steer_friction steer_damping steer_arm "
    "load_brake load_drive wear "
    # once per turn of the wheel
    "para_fx para_fz para_phase runout runout_phase runout_rolling "
    "nu1 nu2 nu3 nu_phase nu_rolling wheel_encoder_play "
    # time
    "skew lag dt",
    "tire_steps drive_steps mapped road_encoder estop_wheel steer_on_hub",
)

MACHINE_STATE = _record(
    "t pinion speed pinion_velocity plank road road_before road_velocity w_rack w_road w_y y_road "
    "lateral slope_force height steer steer_play wheel_camber road_camber pressure "
    "alpha gamma fz kappa "
    "theta omega motor motor_velocity offset torque spring joined stuck_motor wheel_shaft "
    "drag push w_weld weld_hold step_delay",
    "cycle run armed limit_front limit_rear friction_sign region",
)

OPERATOR = _record(
    "stop_position height lateral load steer wheel_camber road_camber pressure",
    "direction fast use_stop load_mode estop flexplates",
)

DRIVE = _record(
    "counts torque_limit velocity_limit profile_velocity acceleration quick_deceleration "
    "torque_slope position_gain gain integral_gain inertia friction blocked_time window "
    "velocity_window scale start_delay",
    "watchdog fitted",
)

DRIVE_STATE = _record(
    "motor velocity torque v_ref v_start integral target slope_torque home blocked load waited "
    "held even late",
    "state mode kind error control control_before last_target homing_done reached stuck inject",
)


class Truth(NamedTuple):
    """True values of one cycle, hidden from the nodes, in the order in which the kernel writes
    them."""

    t: float
    """time [s]"""
    fx: float
    """forces of the road on the tire, ISO W [N]"""
    fy: float
    fz: float
    mx: float
    """moments at the contact, ISO W [N m]"""
    my: float
    mz: float
    road_position: float
    """position of the road plate under the tire [m]"""
    road_velocity: float
    """[m/s]"""
    plank_position: float
    """true position of the plank, with all errors of the rack [m]"""
    pinion_position: float
    """travel of the pinion, which the plank encoder measures [m]"""
    wheel_angle: float
    """[rad]"""
    wheel_velocity: float
    """[rad/s]"""
    motor_angle: float
    """angle of the motor of the wheel drive [rad]"""
    motor_velocity: float
    """[rad/s]"""
    motor_torque: float
    """[N m]"""
    gear_torque: float
    """torque of the gear spring, at the motor [N m]"""
    gear_gap: float
    """motor angle ahead of the geared wheel angle [rad]"""
    kappa: float
    """longitudinal slip [-]"""
    effective_rolling_radius: float
    """[m]"""
    axle_height: float
    """height of the axle over the road [m]"""
    alpha: float
    """side slip angle [rad]"""
    gamma: float
    """camber angle [rad]"""
    pressure: float
    """inflation pressure [bar]"""
    carcass_x: float
    """deflection of the carcass [m]"""
    carcass_y: float
    contact_half_length: float
    """[m]"""
    friction: float
    """mu [-]"""
    sliding_share: float
    """share of the bristles in contact that slide [-]"""
    road_gap: float
    """position of the road plate in its play, ahead of the plank [m]"""
    rack_gap: float
    """position of the plank in the backlash of the rack, ahead of the pinion [m]"""
    run: float
    """number of runs on this road, for its wear [-]"""


COMMAND_FIELDS = 5
"""control word, mode, position, velocity, torque of one axis"""

MAP_START = 0.2
"""distance from the first row of the road map to the rest position of the plank [m]"""
MAP_STEP = 0.002
"""row spacing of the road map [m]; columns: friction factor, height of the plank, height of a
cleat, error of the plank's travel in this run"""
MAP_ROWS = 1.0 / MAP_STEP
"""rows of the road map per metre"""
