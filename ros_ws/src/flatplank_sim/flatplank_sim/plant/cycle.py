# SPDX-License-Identifier: Apache-2.0
"""One bus cycle of the bench: drives, mechanics in small steps, then the sensors."""

from __future__ import annotations

import math

from flatplank_sim.plant.bridges import read_bridges
from flatplank_sim.plant.compiling import entry, inner
from flatplank_sim.plant.drives import (
    ENABLED,
    check_blocked,
    counts,
    drive,
    free_motor,
    hold_step,
    status_word,
    wrap32,
)
from flatplank_sim.plant.drivetrain import substep
from flatplank_sim.plant.road import (
    TURN,
    advance_road,
    advance_tire,
    operator_axes,
    plank_speed,
    rolling_radius,
)

WHEEL, PLANK, STEER, VERTICAL, CAMBER = range(5)
TRIGGER, ESTOP_OK, LIMIT_FRONT, LIMIT_REAR = 1, 2, 4, 8


@inner
def move_axes(m, s, op, d, ds, dt):
    """Move the axes with drives; returns the pinion speed [m/s], NaN without a plank drive."""
    v = math.nan
    for a in range(1, 5):
        if not d[a].fitted:
            continue
        front = back = False
        if a == PLANK:
            ds[a].load = -s.push * d[a].scale
            front, back = s.limit_front > 0, s.limit_rear > 0
        elif a == VERTICAL:
            ds[a].load = -s.fz * d[a].scale
            front, back = s.height >= m.height_max, s.height <= m.height_min
        # the handwheel moves an axis whose drive is off
        enabled = ds[a].state == ENABLED
        before = ds[a].motor
        free_motor(d[a], ds[a], dt, front, back)
        step = (ds[a].motor - before) * d[a].scale
        if a == PLANK:
            v = step / dt
        elif a == STEER:
            s.steer += step
            op.steer = s.steer if enabled else op.steer
        elif a == VERTICAL:
            s.height += step
            op.height = s.height if enabled else op.height
        else:
            s.road_camber += step
            op.road_camber = s.road_camber if enabled else op.road_camber
    return v


@inner
def turn_wheel(m, s, ts, d, ds, curve, re, dx, dt, k):
    """Move motor and wheel during one step of the tire; the tire force follows its tangent
    stiffness."""
    fx = ts.fx
    slope = s.height * ts.gx * re
    steps = m.tire_steps * m.drive_steps
    for i in range(m.drive_steps):
        share = (k * m.drive_steps + i + 1) / steps
        v_ref = ds.v_start + share * (ds.v_ref - ds.v_start)
        fx -= ts.gx * dx / m.drive_steps
        last = s.theta
        substep(
            m, s, d, ds, curve, dt / m.drive_steps, ds.kind, v_ref, ds.slope_torque, s.height * fx,
            slope, s.drag,
        )  # fmt: skip
        fx += ts.gx * re * (s.theta - last)


@inner
def mechanics(m, s, p, ts, bristles, op, d, ds, curve, road_map, k):
    """One step of the tire with its substeps of the drive train."""
    dt = m.dt / m.tire_steps
    operator_axes(m, s, op, p, dt)
    v_pinion = move_axes(m, s, op, d, ds, dt)
    if not d[PLANK].fitted:
        v_pinion = plank_speed(m, s, op, dt)
    s.gamma = s.wheel_camber + s.road_camber
    dx, dy, turn = advance_road(m, s, p, ts, road_map, v_pinion, dt)
    re = rolling_radius(m, s, p, ts)
    s.drag = p.rolling * s.fz * s.height + m.bearing_torque
    before = s.theta
    turn_wheel(m, s, ts, d[WHEEL], ds[WHEEL], curve, re, dx, dt, k)
    dq = re * (s.theta - before)
    advance_tire(m, s, p, ts, bristles, road_map, dq, dx, dy, turn, dt)
    forward = s.road_velocity * math.cos(s.alpha)
    s.kappa = re * s.omega / forward - 1.0 if abs(forward) > 1e-6 else 0.0


@inner
def switches(m, s, op):
    """Digital inputs; increments the run counter when the plank passes the trigger forward."""
    word = 0
    if m.trigger_at <= s.plank <= m.trigger_at + m.trigger_length:
        word |= TRIGGER
        if s.armed and s.pinion_velocity > 0.0:
            s.run += 1
            s.armed = 0
    elif s.plank < m.trigger_at:
        s.armed = 1
    if not op.estop:
        word |= ESTOP_OK
    s.limit_front = 1 if s.plank >= m.road_length else 0
    s.limit_rear = 1 if s.plank <= -m.switch_travel else 0
    if s.limit_front:
        word |= LIMIT_FRONT
    if s.limit_rear:
        word |= LIMIT_REAR
    return word


@inner
def encode(m, s, d, ds, digital, noise, out):
    """Write encoders, digital inputs and reports of the drives to `out`, as integers."""
    out[0] = wrap32(int(math.floor(s.pinion / m.pinion_radius / TURN * m.pinion_counts)))
    half = 0.5 * m.wheel_encoder_play
    s.wheel_shaft = min(max(s.wheel_shaft, s.theta - half), s.theta + half)
    out[1] = wrap32(int(math.floor(s.wheel_shaft / TURN * m.wheel_counts)))
    steer = s.alpha if m.steer_on_hub else s.steer
    out[2] = wrap32(int(math.floor(steer / TURN * m.steer_counts)))
    out[3] = wrap32(int(math.floor(s.road_camber / TURN * m.camber_counts)))
    out[4] = wrap32(int(math.floor(s.road / m.road_resolution))) if m.road_encoder else 0
    out[5] = digital
    for a in range(5):
        k = 6 + 6 * a
        if not d[a].fitted:
            continue
        limited = abs(ds[a].torque) >= 0.999 * d[a].torque_limit
        if a == PLANK and (s.limit_front or s.limit_rear):
            limited = True
        torque = ds[a].torque
        if ds[a].kind != 0:
            torque += m.noise_torque * noise[7]
        out[k] = status_word(ds[a], limited)
        out[k + 1] = max(ds[a].mode, 0)
        out[k + 2] = counts(d[a], ds[a])
        out[k + 3] = int(math.floor(ds[a].velocity / TURN * d[a].counts + 0.5))
        out[k + 4] = int(math.floor(torque * 1e4 + 0.5))
        out[k + 5] = ds[a].error


@inner
def write_truth(s, p, ts, out):
    """Write the true values of this cycle to `out`, in the order of `layout.Truth`."""
    values = (
        s.t, ts.fx + s.slope_force, ts.fy, s.fz, ts.uy * s.fz, -p.rolling * s.fz * s.height, ts.mz,
        s.road, s.road_velocity, s.plank, s.pinion,
        s.theta, s.omega, s.motor, s.motor_velocity, s.torque, s.spring,
        0.0, s.kappa, ts.re, s.height, s.alpha, s.gamma, s.pressure,
        ts.ux, ts.uy, ts.a, ts.friction, ts.slide_share, s.w_road, s.w_rack, float(s.run),
    )  # fmt: skip
    for i in range(len(values)):
        out[i] = values[i]


@inner
def command_drives(m, s, op, d, ds, commands, count):
    """Pass the present command to each fitted drive."""
    for a in range(5):
        if d[a].fitted:
            age = count - 1 - commands[a, 5]
            allowed = not op.estop or (a == WHEEL and not m.estop_wheel)
            drive(d[a], ds[a], commands[a], age, m.dt, allowed)
    if s.step_delay > 0.0 and s.pinion_velocity != 0.0 and ds[WHEEL].state == ENABLED:
        hold_step(d[WHEEL], ds[WHEEL], m.dt, s.step_delay)
    s.stuck_motor = 1.0 if ds[WHEEL].stuck else 0.0


@entry
def cycle(
    machine, state, tire, tire_state, bristles, operator, drives, drive_state, commands, curve,
    road_map, mix, drift, history, work, noise_block, noise_row, count, out_volts, out_counts,
    out_truth,
):  # fmt: skip
    """Bus cycle `count`: integrate from the last cycle (not for cycle 0), then sample."""
    m, s, p, ts, op = machine[0], state[0], tire[0], tire_state[0], operator[0]
    d, ds = drives, drive_state
    s.cycle = count
    s.t = count * m.dt
    if count > 0:
        command_drives(m, s, op, d, ds, commands, count)
        for k in range(m.tire_steps):
            mechanics(m, s, p, ts, bristles, op, d, ds, curve, road_map, k)
        wheel = ds[WHEEL]
        wheel.motor, wheel.velocity, wheel.torque = s.motor, s.motor_velocity, s.torque
        for a in range(5):
            if d[a].fitted:
                check_blocked(d[a], ds[a], m.dt)
    noise = noise_block[noise_row]
    read_bridges(m, s, p, ts, mix, drift, work, history, noise, out_volts)
    encode(m, s, d, ds, switches(m, s, op), noise, out_counts)
    write_truth(s, p, ts, out_truth)
    out_truth[17] = s.motor - m.gear * s.theta - s.offset
