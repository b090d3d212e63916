# SPDX-License-Identifier: Apache-2.0
"""Kinematic chain from the operator's switches to the road under the tire."""

from __future__ import annotations

import math

from flatplank_sim.plant.compiling import inner
from flatplank_sim.plant.drivetrain import ramp
from flatplank_sim.plant.layout import MAP_ROWS, MAP_START
from flatplank_sim.plant.tire import advance, map_row

TURN = 2.0 * math.pi


@inner
def force_beyond_friction(push, friction):
    """Part of a force beyond the dry friction."""
    return push - min(max(push, -friction), friction)


@inner
def switch_speed(m, s, op):
    """Speed set by the plank switches [m/s]; they go to stop by themselves at stop_position."""
    if op.estop or op.direction == 0:
        return 0.0
    speed = m.slow
    if op.fast:
        speed = m.fast if op.direction > 0 else m.return_speed
    speed *= 1.0 + m.speed_error
    if op.use_stop:
        left = (op.stop_position - s.plank) * op.direction
        if left < 2e-5:
            op.direction = 0
            return 0.0
        speed = min(speed, math.sqrt(1.8 * m.acceleration * left))
    return speed * op.direction


@inner
def plank_speed(m, s, op, dt):
    """Mean plank speed at the pinion [m/s]: ramp, limit switches, droop under the tire force."""
    goal = switch_speed(m, s, op)
    most = (m.estop_deceleration if op.estop else m.acceleration) * dt
    if s.limit_front and goal > 0.0 or s.limit_rear and goal < 0.0:
        goal = 0.0
        op.direction = 0
        most = m.estop_deceleration * dt
    before = s.speed
    s.speed = ramp(before, goal, most)
    return 0.5 * (before + s.speed) * (1.0 + m.droop * s.push)


@inner
def rack_gap(m, s, stiffness, v_pinion, dt):
    """Backlash of the rack: a tire that pushes beyond friction moves the plank ahead."""
    if m.rack_gap <= 0.0:
        return 0.0
    free = force_beyond_friction(s.push, m.rack_friction) / m.gap_damping
    step = (free - v_pinion) * dt / (1.0 + stiffness * dt / m.gap_damping)
    before = s.w_rack
    s.w_rack = min(max(before + step, 0.0), m.rack_gap)
    return s.w_rack - before


@inner
def position_in_gap(w, gap, friction, damping, push, stiffness, dt):
    """New position of a part in a gap with dry friction, moved by `push` [N]."""
    if gap <= 0.0:
        return w
    free = force_beyond_friction(push, friction)
    return min(max(w + free / (stiffness + damping / dt), 0.0), gap)


@inner
def mesh_error(m, x):
    """Mesh error of rack and pinion [m] at pinion travel x, with the periods of a tooth and a
    turn."""
    return m.mesh_tooth * math.sin(
        TURN * x / m.mesh_pitch + m.mesh_phase
    ) + m.mesh_turn * math.sin(x / m.pinion_radius + m.mesh_phase)


@inner
def torn_weld(m, s, v_drive, dt):
    """Speed of the pinion ahead of its drive [m/s], through the torn weld of its shaft: a driving
    tire that pushes beyond the hold of the crack turns the pinion on, up to the gap."""
    if m.weld_gap <= 0.0:
        return 0.0
    ahead = 0.0
    if s.push > (0.0 if s.w_weld > 0.0 else s.weld_hold) and s.w_weld < m.weld_gap:
        ahead = min(m.weld_speed, (m.weld_gap - s.w_weld) / dt)
    elif s.push < 0.0 and s.w_weld > 0.0 or v_drive <= 0.0:
        ahead = -min(m.weld_speed, s.w_weld / dt)
    s.w_weld += ahead * dt
    return ahead


@inner
def move_road(m, s, ts, road_map, v_drive, dt):
    """Travel of the road along the plank and across it in this step [m]."""
    cos = math.cos(s.alpha)
    sin = math.sin(s.alpha)
    s.push = ts.fx * cos + ts.fy * sin
    stiffness = ts.gx * cos * cos + ts.gy * sin * sin
    v_pinion = v_drive + m.weld_seen * torn_weld(m, s, v_drive, dt)
    s.pinion += v_pinion * dt
    s.pinion_velocity = v_pinion
    rack_gap(m, s, stiffness, v_pinion, dt)
    s.plank = (
        s.pinion * (1.0 + m.scale_error) + mesh_error(m, s.pinion) - mesh_error(m, 0.0) + s.w_rack
    )
    if m.weld_gap > 0.0:
        s.plank += (1.0 - m.weld_seen) * s.w_weld
    if m.scatter_travel > 0.0:
        s.plank += road_map_value(road_map, s.pinion, 3)
    s.w_road = position_in_gap(
        s.w_road, m.road_gap, m.road_friction, m.gap_damping, s.push, stiffness, dt
    )
    road = s.plank + s.w_road
    step = road - s.road
    s.road = road
    side = ts.fx * sin - ts.fy * cos
    s.w_y = position_in_gap(
        s.w_y, m.support_gap_y, m.support_friction, m.gap_damping, side, ts.gy, dt
    )
    y = s.w_y - s.lateral
    if m.wander != 0.0:
        y += m.wander * math.sin(TURN * s.plank / m.wander_period + m.wander_phase)
    side_step = y - s.y_road
    s.y_road = y
    return step, side_step


@inner
def steer_hub(m, s, ts, dt):
    """Turn of the hub about z within the play of the worm; returns the change of alpha [rad]."""
    if m.steer_play > 0.0:
        free = force_beyond_friction(ts.mz + ts.fx * m.steer_arm, m.steer_friction)
        half = 0.5 * m.steer_play
        # a positive moment turns the wheel to the left, which lowers alpha
        s.steer_play = min(max(s.steer_play - free / m.steer_damping * dt, -half), half)
    alpha = s.steer + m.steer_error + s.steer_play
    change = alpha - s.alpha
    s.alpha = alpha
    return change


@inner
def road_map_value(road_map, x, column):
    """Value of a column of the road map at position x [m], by linear interpolation."""
    f = (x + MAP_START) * MAP_ROWS
    k = map_row(x, road_map.shape[0] - 1)
    w = min(max(f - k, 0.0), 1.0)
    return road_map[k, column] * (1.0 - w) + road_map[k + 1, column] * w


@inner
def vertical_load(m, s, p, ts, road_map):
    """Load [N] from axle height, run-out, undulation, play of the support and fx."""
    deflection = p.r0 - s.height
    if m.runout != 0.0:
        deflection += m.runout * math.cos(s.theta - m.runout_phase)
    if m.mapped:
        deflection += road_map_value(road_map, s.road, 1) + road_map_value(road_map, s.road, 2)
    if m.support_gap_z > 0.0:
        share = (s.fz - m.support_from) / (m.support_to - m.support_from)
        share = min(max(share, 0.0), 1.0)
        deflection -= m.support_gap_z * share * share * (3.0 - 2.0 * share)
    s.slope_force = 0.0
    if deflection <= 0.0:
        return 0.0
    fz = p.cz * (s.pressure / p.p0) ** p.cz_p * deflection
    fz *= 1.0 + ts.fx * (m.load_drive if ts.fx > 0.0 else m.load_brake)
    if m.nu1 != 0.0 or m.nu2 != 0.0 or m.nu3 != 0.0:
        fz += uniformity(m, s.theta)
    if m.mapped:
        rise = road_map_value(road_map, s.road + 1e-3, 2) - road_map_value(
            road_map, s.road - 1e-3, 2
        )
        s.slope_force = -fz * rise / 2e-3
    return max(fz, 0.0)


@inner
def uniformity(m, theta):
    """Radial force variation of the tire [N]: orders 1 to 3 of the wheel angle."""
    return (
        m.nu1 * math.cos(theta - m.nu_phase)
        + m.nu2 * math.cos(2.0 * theta - 2.0 * m.nu_phase)
        + m.nu3 * math.cos(3.0 * theta - 3.0 * m.nu_phase)
    )


@inner
def advance_road(m, s, p, ts, road_map, v_pinion, dt):
    """Advance road, steering and load by dt [s]; returns the travel of the wheel over the road
    along and across its plane [m], and its turn about z [rad].
    """
    dx_road, dy_road = move_road(m, s, ts, road_map, v_pinion, dt)
    turn = -steer_hub(m, s, ts, dt)
    s.road_velocity = dx_road / dt
    s.fz = vertical_load(m, s, p, ts, road_map)
    cos = math.cos(s.alpha)
    sin = math.sin(s.alpha)
    return dx_road * cos + dy_road * sin, dx_road * sin - dy_road * cos, turn


@inner
def advance_tire(m, s, p, ts, bristles, road_map, dq, dx, dy, turn, dt):
    """One step of the tire on the worn road; arguments as in `advance`."""
    wear = max(1.0 - m.wear * s.run, 0.3)
    advance(
        p, ts, bristles, s.fz, s.pressure, dq, dx, dy, turn, s.gamma, s.road, wear, road_map,
        m.mapped > 0, dt,
    )  # fmt: skip


@inner
def rolling_radius(m, s, p, ts):
    """Momentary effective rolling radius [m], with its variation over a turn."""
    re = ts.re
    if m.runout_rolling != 0.0:
        re += m.runout_rolling * math.cos(s.theta - m.runout_phase)
    if m.nu_rolling != 0.0 and s.fz > 0.0:
        re += m.nu_rolling * uniformity(m, s.theta)
    return re


@inner
def operator_axes(m, s, op, p, dt):
    """Move axle height, steering, cambers and pressure to their targets at their speeds."""
    if op.load_mode:
        missing = op.load - s.fz
        stiffness = p.cz * (s.pressure / p.p0) ** p.cz_p
        step = (
            min(max(m.load_gain * missing / stiffness, -m.vertical_speed), m.vertical_speed) * dt
        )
        if s.height > p.r0:
            step = min(m.vertical_speed * dt, max(s.height - p.r0, 1e-6))
        if abs(missing) < 0.5:
            op.load_mode, step = 0, 0.0
        s.height = min(max(s.height - step, m.height_min), m.height_max)
        op.height = s.height
    else:
        s.height = ramp(s.height, op.height, m.vertical_speed * dt)
    s.steer = ramp(s.steer, op.steer, m.steer_speed * dt)
    s.wheel_camber = ramp(s.wheel_camber, op.wheel_camber, m.camber_speed * dt)
    s.road_camber = ramp(s.road_camber, op.road_camber, m.camber_speed * dt)
    s.lateral = ramp(s.lateral, op.lateral, m.vertical_speed * dt)
    s.pressure = op.pressure
