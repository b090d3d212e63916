# SPDX-License-Identifier: Apache-2.0
"""Kernel of the second tire and machine: rubber cells that move through the contact patch.

It shares no formula with the models of the analysis and the simulated plant. The pressure is flat
with steep ends (1 - x^4). Grip falls with the sliding speed. Each cell has one friction circle for
both directions. The carcass is a spring in series, with softening and creep.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

#: parameters of one run, in the order in which the kernel gets them
NAMES = (
    "tread_x", "tread_y", "half", "grip", "grip_lost", "grip_speed", "carcass_x", "carcass_y",
    "softening", "creep", "creep_time", "brake_grip", "brake_tread", "circle", "nominal",
    "speed", "wheel_speed", "delay", "step", "kappa", "radius", "start", "alpha", "camber_slip",
    "play", "play_hold", "drive_gap", "rack_gap", "ripple", "ripple_period", "ripple_phase",
    "scale_error", "droop", "loss_brake", "loss_drive", "out_1", "out_2", "out_3", "out_load",
    "uneven", "wave_load", "wave_period", "wave_phase",
    "steer_play", "side_gap", "sink_gap", "felt",
)  # fmt: skip
AT = {name: i for i, name in enumerate(NAMES)}
(
    TREAD_X, TREAD_Y, HALF, GRIP, GRIP_LOST, GRIP_SPEED, CARCASS_X, CARCASS_Y,
    SOFTENING, CREEP, CREEP_TIME, BRAKE_GRIP, BRAKE_TREAD, CIRCLE, NOMINAL,
    SPEED, WHEEL_SPEED, DELAY, STEP, KAPPA, RADIUS, START, ALPHA, CAMBER_SLIP,
    PLAY, PLAY_HOLD, DRIVE_GAP, RACK_GAP, RIPPLE, RIPPLE_PERIOD, RIPPLE_PHASE,
    SCALE_ERROR, DROOP, LOSS_BRAKE, LOSS_DRIVE, OUT_1, OUT_2, OUT_3, OUT_LOAD,
    UNEVEN, WAVE_LOAD, WAVE_PERIOD, WAVE_PHASE,
    STEER_PLAY, SIDE_GAP, SINK_GAP, FELT,
) = range(47)  # fmt: skip
CELLS = 56
OUT = ("pinion", "wheel", "fx", "fy", "load", "shown")
SAMPLE, SUB = 0.05, 2
"""sampling time of the table [s], steps per sample"""


@njit(cache=True, nogil=True)
def cells_force(p, carried, moved, dx, dy, load, grip, trial):
    """Forces of all cells after a shift (dx, dy) of the belt; stiffness of the sticking cells."""
    fx = fy = sx = sy = 0.0
    width = 2.0 * p[HALF] / CELLS
    for j in range(CELLS):
        x = (j + 0.5) / CELLS * 2.0 - 1.0
        part = 1.0 - 0.5 * moved if j == 0 else 1.0
        bx = carried[0, j] + part * dx
        by = carried[1, j] + part * dy
        kx = p[TREAD_X] * width * load / p[NOMINAL]
        ky = p[TREAD_Y] * width * load / p[NOMINAL]
        limit = 1.25 / CELLS * (1.0 - x**4) * grip * load
        if bx < 0.0:
            limit *= 1.0 - p[BRAKE_GRIP]
            kx *= 1.0 - p[BRAKE_TREAD]
        tx, ty = kx * bx, ky * by
        if p[CIRCLE] > 0.5:
            size = math.sqrt(tx * tx + ty * ty)
            share = limit / size if size > limit else 1.0
            share_x = share_y = share
        else:
            share_x = limit / abs(tx) if abs(tx) > limit else 1.0
            share_y = limit / abs(ty) if abs(ty) > limit else 1.0
        if p[CIRCLE] > 0.5 and share_x < 1.0:
            # a sliding cell keeps its stiffness across its force
            sx += part * kx * share_x * ty * ty / (tx * tx + ty * ty)
            sy += part * ky * share_y * tx * tx / (tx * tx + ty * ty)
        else:
            sx += part * kx if share_x == 1.0 else 0.0
            sy += part * ky if share_y == 1.0 else 0.0
        trial[0, j], trial[1, j] = bx * share_x, by * share_y
        fx += tx * share_x
        fy += ty * share_y
    return fx, fy, sx, sy


@njit(cache=True, nogil=True)
def tire_step(p, bend, carcass, rolled, slip, side, load, friction, h, trial):
    """One step of the tire; updates bend (2, CELLS) and carcass = (ux, uy, delayed ux, fx, fy)."""
    width = 2.0 * p[HALF] / CELLS
    share = min(max(rolled / width, 0.0), 1.0)
    carried = np.empty_like(bend)
    for a in range(2):
        for j in range(CELLS):
            before = bend[a, j - 1] if j > 0 else 0.0
            carried[a, j] = (1.0 - share) * bend[a, j] + share * before
    ratio = abs(slip) / h / p[GRIP_SPEED]
    grip = p[GRIP] * friction * (1.0 - p[GRIP_LOST] * ratio / (1.0 + ratio))
    if p[CREEP] > 0.0:
        aim = p[CREEP] * carcass[3] / p[CARCASS_X]
        carcass[2] += (aim - carcass[2]) * (1.0 - math.exp(-h / p[CREEP_TIME]))
    ux, uy = carcass[0], carcass[1]
    fx = fy = 0.0
    for _ in range(9):
        dx, dy = slip - (ux - carcass[0]), side - (uy - carcass[1])
        fx, fy, sx, sy = cells_force(p, carried, share, dx, dy, load, grip, trial)
        v = ux - carcass[2]
        soft = 1.0 + p[SOFTENING] * abs(v)
        miss_x = fx - p[CARCASS_X] * v / soft
        miss_y = fy - p[CARCASS_Y] * uy
        if abs(miss_x) + abs(miss_y) < 0.02:
            break
        ux += miss_x / (sx + p[CARCASS_X] / soft**2)
        uy += miss_y / (sy + p[CARCASS_Y])
    bend[:, :] = trial
    carcass[0], carcass[1], carcass[3], carcass[4] = ux, uy, fx, fy


@njit(cache=True, nogil=True)
def through_gap(at, gap, force, hold, stiffness):
    """Position of a part in a gap under a force, with friction `hold`."""
    if gap <= 0.0:
        return at
    push = 0.0
    if force > hold:
        push = force - hold
    elif force < -hold:
        push = force + hold
    return min(max(at + 0.7 * push / stiffness, -0.5 * gap), 0.5 * gap)


@njit(cache=True, nogil=True)
def dragged(ahead, follower, gap):
    """Position of a follower that lags by at most the gap."""
    return min(max(follower, ahead - gap), ahead + gap)


@njit(cache=True, nogil=True)
def driven(p, t, h, pinion, speed, fx):
    """Drives of plank and wheel over a step: speed [m/s] and travel [m] of the plank, travel of
    the wheel without and with slip [m].
    """
    if t > 0.5:
        speed = min(speed + 0.206 * h, p[SPEED])
    travel = speed * h * (1.0 + 1e-7 * fx)
    on = 1.0 if t > 0.5 + p[DELAY] else 0.0
    extra = p[KAPPA] if pinion > p[STEP] else 0.0
    free = p[WHEEL_SPEED] * h * on
    return speed, travel, free, free * (1.0 + extra)


@njit(cache=True, nogil=True)
def load_of(p, x, angle, fx, bumps):
    """Load on the tire [N], and the part of it that the hub does not measure."""
    load = p[NOMINAL] + bumps[0] * math.sin(x / 0.207 + bumps[1])
    load += bumps[2] * math.cos(x / 0.0796 + bumps[3])
    out = p[OUT_1] * math.cos(angle - 0.7) + p[OUT_2] * math.cos(2.0 * angle - 0.4)
    out += p[OUT_3] * math.cos(3.0 * angle + 0.5)
    load += p[OUT_LOAD] * out + p[UNEVEN] * math.cos(angle + 0.9)
    if fx < 0.0:
        load *= 1.0 + p[LOSS_BRAKE] * fx / p[NOMINAL]
    else:
        load *= 1.0 + p[LOSS_DRIVE] * fx / p[NOMINAL]
    load += 1.06e5 * p[SINK_GAP] * math.tanh(fx / 150.0)
    unseen = p[WAVE_LOAD] * load * math.sin(2.0 * math.pi * x / p[WAVE_PERIOD] + p[WAVE_PHASE])
    return load, out, unseen


@njit(cache=True, nogil=True)
def run_one(p, friction, bumps, out):
    """Simulate one run from standstill; out: shape (len(OUT), samples); returns the number of
    samples."""
    h = SAMPLE / SUB
    bend, trial = np.zeros((2, CELLS)), np.zeros((2, CELLS))
    carcass = np.zeros(5)
    pinion = wheel = speed = plate = side_at = last_ripple = 0.0
    ahead = drive = rack = 0.0
    stiffness = 0.6 * p[CARCASS_X]
    total = out.shape[1] * SUB
    for n in range(total):
        t = n * h
        fx, fy = carcass[3], carcass[4]
        speed, travel, free, turned = driven(p, t, h, pinion, speed, fx)
        pinion += travel
        wheel += turned
        angle = wheel / p[RADIUS] + p[START]
        ripple = p[RIPPLE] * math.sin(2.0 * math.pi * pinion / p[RIPPLE_PERIOD] + p[RIPPLE_PHASE])
        road = travel * (1.0 + p[SCALE_ERROR] + p[DROOP] * fx) + ripple - last_ripple
        last_ripple = ripple
        ahead += turned - free
        old_drive, old_rack = drive, rack
        drive, rack = dragged(ahead, drive, p[DRIVE_GAP]), dragged(ahead, rack, p[RACK_GAP])
        lost = 0.0
        if p[DRIVE_GAP] > 0.0:
            lost += turned - free - (drive - old_drive)
        if p[RACK_GAP] > 0.0:
            road += turned - free - (rack - old_rack)
        load, radial, unseen = load_of(p, pinion, angle, fx, bumps)
        rolled = (turned - lost) * (1.0 + radial / p[RADIUS])
        before = plate
        plate = through_gap(plate, p[PLAY], fx, p[PLAY_HOLD], stiffness)
        slip = rolled - road - (plate - before)
        # the force acts behind the steering axis and turns the wheel towards the road's direction
        steer = p[ALPHA] + p[STEER_PLAY] * fy / math.sqrt(fy * fy + 400.0)
        before = side_at
        side_at = through_gap(side_at, p[SIDE_GAP], fy, 25.0, 0.6 * p[CARCASS_Y])
        side = -math.tan(steer) * road + p[CAMBER_SLIP] * road - (side_at - before)
        k = min(int(max(pinion, 0.0) * 500.0), friction.shape[0] - 1)
        felt = load + unseen - p[FELT] * (load - p[NOMINAL])
        tire_step(p, bend, carcass, rolled, slip, side, felt, friction[k], h, trial)
        if n % SUB == SUB - 1:
            i = n // SUB
            out[0, i], out[1, i] = pinion, wheel / p[RADIUS]
            out[2, i], out[3, i], out[4, i], out[5, i] = carcass[3], carcass[4], felt, load
            if pinion > 4.15:
                return i + 1
    return out.shape[1]
