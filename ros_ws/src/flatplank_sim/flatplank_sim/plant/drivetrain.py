# SPDX-License-Identifier: Apache-2.0
"""The wheel rotation actuator: thesis equations (5.15)-(5.21), with the self-locking of the
slewing drive.

Motor:  J_M d omega_M/dt = M_M - T/eta (driving) - M_F
Gears:  T = eta f(theta_D), f the spring with dead zone (5.16), theta_D = theta_M - i theta_T
Wheel:  J_TW d omega_T/dt = i T - M_T

The loss (1/eta - 1) T is friction that grows with the load. That friction alone carries a load in
the direction of motion: the load does not reach the motor, which needs only M_F (Figure 5.13). At
rest the friction holds any load on the wheel. The solver is backward Euler; it tries the few
states of gap and friction until one is consistent.
"""

from __future__ import annotations

from flatplank_sim.plant.compiling import inner

OFF, VELOCITY, TORQUE = 0, 1, 2
"""modes of the servo"""


@inner
def ramp(value, target, most):
    return value + min(max(target - value, -most), most)


@inner
def interpolate(table, x):
    """Linear interpolation between rows of (x, value), constant beyond the ends."""
    n = table.shape[0]
    if x <= table[0, 0]:
        return table[0, 1]
    for k in range(1, n):
        if x < table[k, 0]:
            w = (x - table[k - 1, 0]) / (table[k, 0] - table[k - 1, 0])
            return table[k - 1, 1] + w * (table[k, 1] - table[k - 1, 1])
    return table[n - 1, 1]


@inner
def friction_torque(curve, speed):
    """M_F [N m] at a motor speed [rad/s] from the table of the machine (rows: speed, torque)."""
    return interpolate(curve, abs(speed))


@inner
def gear_side(m, s, h, region, a_w, b_w):
    """Gear torque as t0 + t1 * motor speed for one side of the gap, with the wheel eliminated."""
    if region == 0:
        return 0.0, 0.0
    gap = s.motor - m.gear * s.theta - s.offset
    t0 = m.k_spring * (gap - region * m.backlash)
    g = m.k_spring * h + m.d_spring
    det = a_w + m.gear * m.gear * g
    return (t0 * a_w - m.gear * g * b_w) / det, g * a_w / det


@inner
def settle_motor(m, s, region, t0, t1, a_m, b_m, mf, mf_rest):
    """New motor speed with dry friction (set-valued at rest), direction of the friction."""
    lost = 1.0 / m.efficiency - 1.0
    for attempt in range(3):
        if attempt == 0:
            sign = s.friction_sign
        elif attempt == 1:
            sign = 0 if s.friction_sign != 0 else 1
        else:
            sign = -s.friction_sign if s.friction_sign != 0 else -1
        if sign == 0:
            push = b_m - t0
            load = abs(t0)
            up = mf_rest + load * (lost if t0 > 0.0 else m.lock_ratio)
            down = mf_rest + load * (lost if t0 < 0.0 else m.lock_ratio)
            if -down <= push <= up:
                return 0.0, 0
            continue
        carried = 1.0 + lost if sign * region > 0 else 0.0
        speed = (b_m - sign * mf - carried * t0) / (a_m + carried * t1)
        if speed * sign > 0.0:
            return speed, sign
    return 0.0, 0


@inner
def try_region(m, s, h, region, a_w, b_w, a_m, b_m, mf, mf_rest):
    """Motor and wheel speed, gear torque, friction direction if the gears are in this region."""
    t0, t1 = gear_side(m, s, h, region, a_w, b_w)
    if s.stuck_motor > 0.0:
        speed, sign = 0.0, 0
    else:
        speed, sign = settle_motor(m, s, region, t0, t1, a_m, b_m, mf, mf_rest)
    torque = t0 + t1 * speed
    wheel = (b_w + m.gear * torque) / a_w
    return speed, wheel, torque, sign


@inner
def servo(m, s, d, ds, h, kind, v_ref, torque):
    """Motor equation as a_m * speed = b_m: inertia plus the velocity loop or a fixed torque."""
    a_m = m.j_motor / h
    b_m = a_m * s.motor_velocity
    if kind == VELOCITY:
        gain = d.gain + d.integral_gain * h
        a_m += gain
        b_m += gain * v_ref + ds.integral
    elif kind == TORQUE:
        b_m += torque
    return a_m, b_m


@inner
def solve(m, s, h, a_w, b_w, a_m, b_m, mf, mf_rest):
    """Motor and wheel speed, gear torque, friction direction and side of the gap at the end of the
    step: the first side that is consistent with itself."""
    joined = s.joined > 0.0
    speed = wheel = torque = 0.0
    sign = region = 0
    for attempt in range(3):
        region = 0
        if joined:
            region = s.region if attempt == 0 else (s.region + attempt + 1) % 3 - 1
        speed, wheel, torque, sign = try_region(m, s, h, region, a_w, b_w, a_m, b_m, mf, mf_rest)
        gap = s.motor - m.gear * s.theta - s.offset + h * (speed - m.gear * wheel)
        fits = abs(gap) <= m.backlash if region == 0 else gap * region >= m.backlash - 1e-12
        if fits or not joined:
            break
    return speed, wheel, torque, sign, region


@inner
def substep(m, s, d, ds, curve, h, kind, v_ref, torque, tire_torque, tire_slope, drag):
    """Advance motor and wheel by h [s].

    tire_torque + tire_slope * h * omega is what the tire takes from the wheel [N m]; drag [N m]
    resists rolling.
    """
    joined = s.joined > 0.0
    j_wheel = m.j_wheel if joined else m.j_free
    resist = drag / (abs(s.omega) + m.rolling_speed)
    a_w = j_wheel / h + tire_slope * h + resist
    b_w = j_wheel / h * s.omega - tire_torque
    mf = friction_torque(curve, s.motor_velocity)
    mf_rest = curve[0, 1]
    a_m, b_m = servo(m, s, d, ds, h, kind, v_ref, torque)
    speed, wheel, gear, sign, region = solve(m, s, h, a_w, b_w, a_m, b_m, mf, mf_rest)
    s.torque = torque if kind == TORQUE else 0.0
    if kind == VELOCITY:
        s.torque = ds.integral + (d.gain + d.integral_gain * h) * (v_ref - speed)
        if abs(s.torque) > d.torque_limit:
            s.torque = d.torque_limit if s.torque > 0.0 else -d.torque_limit
            a_m, b_m = servo(m, s, d, ds, h, TORQUE, v_ref, s.torque)
            speed, wheel, gear, sign, region = solve(m, s, h, a_w, b_w, a_m, b_m, mf, mf_rest)
        else:
            ds.integral += d.integral_gain * h * (v_ref - speed)
    s.motor_velocity, s.omega = speed, wheel
    s.motor += h * speed
    s.theta += h * wheel
    s.friction_sign, s.region, s.spring = sign, region, gear
