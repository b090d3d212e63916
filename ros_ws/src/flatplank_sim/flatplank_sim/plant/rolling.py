# SPDX-License-Identifier: Apache-2.0
"""Simulates a whole run in one call: road, tire and bridges with an ideal wheel servo, without bus
and drive loop.

The gear of the wheel is quasi-static: the tire closes backlash and wind-up at once.
"""

from __future__ import annotations

import math

from flatplank_sim.plant.bridges import forces_from_volts, read_bridges
from flatplank_sim.plant.compiling import entry, inner
from flatplank_sim.plant.drivetrain import friction_torque, interpolate
from flatplank_sim.plant.road import (
    TURN,
    advance_road,
    advance_tire,
    plank_speed,
    rolling_radius,
    vertical_load,
)
from flatplank_sim.plant.tire import advance


@inner
def lost_motion(m, s, ts, re, step, dx):
    """Wheel turn for a turn `step` [rad] of the motor side: gap and wind-up of the gear."""
    torque = (s.height * ts.fx + s.drag) / m.gear
    low = -(m.backlash + max(torque, 0.0) / m.k_spring) / m.gear
    high = (m.backlash + max(-torque, 0.0) / m.k_spring) / m.gear
    stiffness = max(ts.gx, 1e3)
    push = ts.fx + ts.gx * (re * step - dx) + s.drag / s.height
    w = min(max(s.offset - push / (stiffness * re), low), high)
    turn = step + w - s.offset
    s.offset = w
    return turn


@inner
def tire_step(m, s, p, ts, bristles, op, road_map, omega, dt):
    """Road, load, wheel and tire over dt [s] with the motor side of the gear at omega [rad/s]."""
    dx, dy, turn = advance_road(m, s, p, ts, road_map, plank_speed(m, s, op, dt), dt)
    re = rolling_radius(m, s, p, ts)
    s.drag = p.rolling * s.fz * s.height + m.bearing_torque if s.plank > 0.0 else 0.0
    if s.joined > 0.0:
        angle = lost_motion(m, s, ts, re, omega * dt, dx)
    else:
        # free wheel: the tire force balances the rolling resistance
        angle = (dx - (ts.fx + s.drag / s.height) / max(ts.gx, 1e3)) / re
    s.theta += angle
    s.omega = angle / dt
    s.motor_velocity = omega * m.gear
    advance_tire(m, s, p, ts, bristles, road_map, re * angle, dx, dy, turn, dt)


@inner
def press_standing_tire(m, s, p, ts, bristles, road_map):
    """Press the standing tire onto the road."""
    for _ in range(5):
        s.fz = vertical_load(m, s, p, ts, road_map)
    advance(
        p, ts, bristles, s.fz, s.pressure, 0.0, 0.0, 0.0, 0.0, s.gamma, s.road, 1.0, road_map,
        m.mapped > 0, m.dt,
    )  # fmt: skip


@inner
def encoder_position(m, s):
    """Plank position by the pinion encoder [m]."""
    per_count = m.pinion_radius * TURN / m.pinion_counts
    return math.floor(s.pinion / per_count) * per_count


@inner
def write_row(m, s, p, ts, curve, work, x, trigger, row):
    """Write one sample of the measurement table, then true fx and road position."""
    height = m.lvdt_zero + m.lvdt_slope * work[16]
    row[0], row[1], row[2] = s.t, x, s.pinion_velocity
    row[3] = math.floor(s.theta / TURN * m.wheel_counts) * TURN / m.wheel_counts
    row[4], row[5] = s.omega, s.motor_velocity
    carried = max(s.height * ts.fx + s.drag, 0.0) / m.gear / m.efficiency
    row[6] = carried + (friction_torque(curve, s.motor_velocity) if s.motor_velocity else 0.0)
    forces_from_volts(m, work[10:16], height, s.gamma, row[7:13])
    row[13] = height
    row[14] = 1.0 if trigger else 0.0
    row[15], row[16] = ts.fx + s.slope_force, s.road


@entry
def roll(
    machine, state, tire, tire_state, bristles, operator, curve, road_map, mix, drift, history,
    work, noise, profile, radius, delay, steps, out,
):  # fmt: skip
    """Simulate one run from standstill; `out` gets a row per sample until the road ends. Returns
    the number of rows.

    profile: plank position since the trigger [m], slip; radius: effective rolling radius of the
    slip control [m]; delay: of the wheel after the plank's switch [s]; steps: tire steps per
    sample.
    """
    m, s, p, ts, op = machine[0], state[0], tire[0], tire_state[0], operator[0]
    dt = m.dt / steps
    cos = math.cos(s.steer)
    zero = math.nan
    rows = out.shape[0]
    press_standing_tire(m, s, p, ts, bristles, road_map)
    for n in range(rows):
        s.cycle = n
        s.t = n * m.dt
        for i in range(steps if n > 0 else 0):
            before = (n - 1) * m.dt + i * dt
            moving = min(max((before + dt - delay) / dt, 0.0), 1.0)
            since = encoder_position(m, s) - (m.trigger_at if math.isnan(zero) else zero)
            kappa = interpolate(profile, since + (0.5 * dt - s.step_delay) * s.pinion_velocity)
            omega = moving * m.fast * cos * (1.0 + kappa) / radius
            tire_step(m, s, p, ts, bristles, op, road_map, omega, dt)
        x = encoder_position(m, s)
        trigger = s.plank >= m.trigger_at
        if trigger and math.isnan(zero):
            zero = x
        read_bridges(m, s, p, ts, mix, drift, work[:10], history, noise[n], work[10:17])
        write_row(m, s, p, ts, curve, work, x, trigger, out[n])
        if s.plank >= m.road_length:
            rows = n + 1
            break
    if not math.isnan(zero):
        out[:rows, 1] -= zero
    return rows
