# SPDX-License-Identifier: Apache-2.0
"""Emulation of a CiA 402 servo drive: state machine, operation modes, watchdog, faults.

One call per bus cycle and axis; the mechanics behind the motor is in other modules.
"""

from __future__ import annotations

import math

from flatplank_hw.cia402 import FAULT_RESET, STATUS, TORQUE_UNIT, CiaMode, State
from flatplank_sim.plant.compiling import inner
from flatplank_sim.plant.drivetrain import OFF, TORQUE, VELOCITY, ramp

# plain numbers: compiled code has no enumerations
NOT_READY, SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP, FAULT_REACTION, FAULT = (
    map(int, State)
)
STATUS_BITS = tuple(STATUS[state] for state in State)
VOLTAGE, REMOTE, REACHED, LIMIT, SPECIFIC = 0x0010, 0x0200, 0x0400, 0x0800, 0x1000

MODES = tuple(map(int, CiaMode))
PROFILE_POSITION, PROFILE_VELOCITY, PROFILE_TORQUE, HOMING = MODES[:4]
CYCLIC_POSITION, CYCLIC_VELOCITY, CYCLIC_TORQUE = MODES[4:]

ERROR_WATCHDOG = 0x7500
"""communication error: no fresh command"""
ERROR_BLOCKED = 0x7121
"""motor blocked"""
NEW_SETPOINT, RELATIVE, HALT, RESET = 0x10, 0x40, 0x100, FAULT_RESET
STOPPED = 10.0
"""speed over the velocity window below which the power stage opens after a stop [-]"""
TURN = 2.0 * math.pi


@inner
def wrap32(x):
    """Wrap a number to int32, as on the bus."""
    return ((x + 2**31) & 0xFFFFFFFF) - 2**31


@inner
def counts(d, ds):
    """Motor position on the bus [counts]."""
    return wrap32(int(math.floor((ds.motor - ds.home) / TURN * d.counts)))


@inner
def trip(ds, code):
    """Enter the fault state: brake first, then open the power stage."""
    if ds.state not in (FAULT_REACTION, FAULT):
        ds.error = code
        ds.state = FAULT_REACTION if ds.state in (ENABLED, QUICK_STOP) else FAULT


@inner
def transition(ds, word):
    """CiA 402 state machine, one transition per cycle."""
    before = ds.control
    ds.control_before, ds.control = before, word
    state = ds.state
    if state == NOT_READY:
        ds.state = SWITCH_ON_DISABLED
    elif state == FAULT:
        if word & RESET and not before & RESET and ds.inject == 0:
            ds.state, ds.error = SWITCH_ON_DISABLED, 0
    elif state == FAULT_REACTION or state == QUICK_STOP and word & 0x02:
        pass
    elif not word & 0x02:
        ds.state = SWITCH_ON_DISABLED
    elif not word & 0x04:
        ds.state = QUICK_STOP if state == ENABLED else SWITCH_ON_DISABLED
    elif state == SWITCH_ON_DISABLED:
        if word & 0x07 == 0x06:
            ds.state = READY
    elif word & 0x07 == 0x06:
        ds.state = READY
    elif state == READY:
        if word & 0x07 == 0x07:
            ds.state = SWITCHED_ON
    elif word & 0x0F == 0x0F:
        ds.state = ENABLED
    elif word & 0x0F == 0x07:
        ds.state = SWITCHED_ON


@inner
def check_watchdog(ds, age, limit):
    """Watchdog: an enabled drive without fresh commands stops by itself."""
    if ds.state == ENABLED and age > limit:
        trip(ds, ERROR_WATCHDOG)
    if ds.inject > 0:
        trip(ds, ds.inject)


@inner
def stop_ramp(d, ds, dt):
    """Quick stop and fault reaction; the power stage opens when the motor rests."""
    ds.kind = VELOCITY
    ds.v_ref = ramp(ds.v_ref, 0.0, d.quick_deceleration * dt)
    # dry friction and the self-locking gear stop the remaining motion at once
    if ds.v_ref == 0.0 and abs(ds.velocity) < STOPPED * d.velocity_window:
        ds.state = FAULT if ds.state == FAULT_REACTION else SWITCH_ON_DISABLED
        ds.kind = OFF


@inner
def move_towards_target(d, ds, dt):
    """Profile position: speed trapezoid to ds.target; returns whether it is reached."""
    error = ds.target - ds.motor
    most = min(math.sqrt(2.0 * d.acceleration * abs(error)), d.position_gain * abs(error))
    speed = math.copysign(min(most, d.profile_velocity), error)
    ds.v_ref = ramp(ds.v_ref, speed, d.acceleration * dt)
    return abs(error) < d.window and abs(ds.velocity) < d.velocity_window


@inner
def follow_position(d, ds, mode, target, rising, dt):
    """Cyclic and profile position; targets are counts that wrap."""
    if mode == CYCLIC_POSITION:
        error = wrap32(target - counts(d, ds)) * TURN / d.counts
        feed = wrap32(target - ds.last_target) * TURN / d.counts / dt
        ds.last_target = target
        ds.v_ref = d.position_gain * error + feed
        return abs(error) < d.window
    if rising:
        start = 0 if ds.control & RELATIVE else counts(d, ds)
        ds.target = ds.motor + wrap32(target - start) * TURN / d.counts
    if ds.control & HALT:
        ds.v_ref = ramp(ds.v_ref, 0.0, d.acceleration * dt)
        return False
    return move_towards_target(d, ds, dt)


@inner
def follow_mode(d, ds, command, dt):
    """Compute the set-points of an enabled drive; returns whether the target is reached."""
    word, mode = ds.control, command[1]
    rising = word & NEW_SETPOINT and not ds.control_before & NEW_SETPOINT
    ds.kind = VELOCITY
    if mode != ds.mode:
        ds.target, ds.last_target = ds.motor, command[2]
        ds.homing_done = 0
        ds.v_ref, ds.slope_torque = ds.velocity, ds.torque
        ds.mode = mode
    if mode == CYCLIC_VELOCITY:
        ds.v_ref = command[3] * TURN / d.counts
        return abs(ds.v_ref - ds.velocity) < d.velocity_window
    if mode == PROFILE_VELOCITY:
        goal = 0.0 if word & HALT else command[3] * TURN / d.counts
        ds.v_ref = ramp(ds.v_ref, goal, d.acceleration * dt)
        return abs(goal - ds.velocity) < d.velocity_window
    if mode in (CYCLIC_TORQUE, PROFILE_TORQUE):
        ds.kind = TORQUE
        most = d.torque_slope * dt if mode == PROFILE_TORQUE else 2.0 * d.torque_limit
        goal = 0.0 if word & HALT else command[4] * TORQUE_UNIT
        ds.slope_torque = ramp(ds.slope_torque, goal, most)
        return ds.slope_torque == goal
    if mode in (CYCLIC_POSITION, PROFILE_POSITION):
        return follow_position(d, ds, mode, command[2], rising, dt)
    ds.v_ref = ramp(ds.v_ref, 0.0, d.acceleration * dt)
    if mode == HOMING:
        if rising:
            ds.home = ds.motor
            ds.homing_done = 1
        return ds.homing_done == 1
    return False


@inner
def hold_start(d, ds, dt):
    """Start delay: a resting motor responds after a delay."""
    wants = abs(ds.v_ref) > 0.0 if ds.kind == VELOCITY else abs(ds.slope_torque) > 0.0
    resting = abs(ds.velocity) < d.velocity_window
    ds.waited = ds.waited + dt if wants else 0.0
    if wants and resting and ds.waited < d.start_delay:
        ds.kind, ds.v_ref = VELOCITY, 0.0


@inner
def hold_step(d, ds, dt, delay):
    """Step delay: a motor that has turned evenly for longer than the delay keeps its speed for the
    delay when its set-point jumps. A speed that is controlled changes all the time."""
    turns = ds.kind == VELOCITY and abs(ds.held) > d.velocity_window
    jumps = turns and abs(ds.v_ref - ds.held) > d.velocity_window
    if jumps and ds.even > delay and ds.late < delay:
        ds.late += dt
        ds.v_ref = ds.held
        return
    ds.even = ds.even + dt if turns and not jumps else 0.0
    ds.late = 0.0
    ds.held = ds.v_ref if ds.kind == VELOCITY else 0.0


@inner
def drive(d, ds, command, age, dt, allowed):
    """One bus cycle of the drive: sets the set-point of the motor (kind, v_start, v_ref,
    slope_torque).

    age: age of the command [cycles]; allowed: false when the emergency stop cuts the drive.
    """
    was_enabled = ds.state == ENABLED
    transition(ds, command[0])
    if age >= 0:
        check_watchdog(ds, age, d.watchdog)
    if not allowed and ds.state == ENABLED:
        ds.state = QUICK_STOP
    if ds.state == ENABLED and not was_enabled:
        ds.mode, ds.integral, ds.waited, ds.blocked = -1, 0.0, 0.0, 0.0
        ds.v_ref = ds.velocity
    kind_before = ds.kind
    ds.v_start = ds.v_ref
    reached = False
    if ds.state == ENABLED:
        reached = follow_mode(d, ds, command, dt)
        if d.start_delay > 0.0:
            hold_start(d, ds, dt)
    elif ds.state == QUICK_STOP or ds.state == FAULT_REACTION:
        stop_ramp(d, ds, dt)
    else:
        ds.kind, ds.v_ref, ds.integral = OFF, 0.0, 0.0
    ds.v_ref = min(max(ds.v_ref, -d.velocity_limit), d.velocity_limit)
    ds.slope_torque = min(max(ds.slope_torque, -d.torque_limit), d.torque_limit)
    if ds.kind == VELOCITY and kind_before == TORQUE:
        ds.integral, ds.v_start = ds.torque, ds.velocity
    if kind_before == OFF:
        ds.v_start = ds.velocity
    ds.reached = 1 if reached else 0


@inner
def check_blocked(d, ds, dt):
    """Trip a motor that stands at its torque limit."""
    against = abs(ds.torque) >= 0.99 * d.torque_limit and abs(ds.velocity) < d.velocity_window
    ds.blocked = ds.blocked + dt if against and ds.state == ENABLED else 0.0
    if ds.blocked > d.blocked_time:
        trip(ds, ERROR_BLOCKED)


@inner
def status_word(ds, limited):
    """Status word with target reached, internal limit and the bit of the mode."""
    word = STATUS_BITS[ds.state] | VOLTAGE | REMOTE
    if ds.reached:
        word |= REACHED
    if limited:
        word |= LIMIT
    if ds.state == ENABLED:
        if ds.mode == HOMING:
            word |= SPECIFIC if ds.homing_done else 0
        elif ds.mode == PROFILE_POSITION:
            word |= SPECIFIC if ds.control & NEW_SETPOINT else 0
        elif ds.mode >= CYCLIC_POSITION:
            word |= SPECIFIC
    return word


@inner
def free_motor(d, ds, dt, blocked_forward, blocked_backward):
    """Motor of an axis without separate mechanics: inertia, dry friction, a load."""
    if ds.kind == VELOCITY:
        goal = ds.v_ref
    elif ds.kind == TORQUE:
        push = ds.slope_torque - ds.load
        rest = abs(ds.velocity) < 1e-9 and abs(push) <= d.friction
        drag = 0.0 if rest else math.copysign(d.friction, ds.velocity if ds.velocity else push)
        goal = ds.velocity if rest else ds.velocity + (push - drag) / d.inertia * dt
        if goal * ds.velocity < 0.0:
            goal = 0.0
    else:
        goal = ramp(ds.velocity, 0.0, d.friction / d.inertia * dt)
    if ds.stuck or blocked_forward and goal > 0.0 or blocked_backward and goal < 0.0:
        goal = 0.0
    most = d.torque_limit / d.inertia * dt
    speed = ramp(ds.velocity, goal, most)
    speed = 0.0 if ds.stuck else speed
    effort = d.inertia * (speed - ds.velocity) / dt + ds.load
    if speed != 0.0:
        effort += math.copysign(d.friction, speed)
    if ds.stuck and ds.kind == VELOCITY and ds.v_ref != 0.0:
        effort = math.copysign(d.torque_limit, ds.v_ref)
    ds.torque = min(max(effort, -d.torque_limit), d.torque_limit) if ds.kind != OFF else 0.0
    ds.motor += 0.5 * (speed + ds.velocity) * dt
    ds.velocity = speed
