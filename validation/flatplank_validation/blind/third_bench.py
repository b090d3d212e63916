# SPDX-License-Identifier: Apache-2.0
"""Kernel of the bench of the third tire: motion, load, and faults of the machine.

In a play a massless part moves between two elastic stops. The load follows a braking force with a
delay. A worn patch has a smooth profile. SI units.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from flatplank_validation.blind.third_kernel import MOST, step

#: parameters of one run, in the order in which the kernel gets them
NAMES = (
    "load", "alpha", "kappa", "radius", "start", "delay", "speed", "step_at", "length",
    "road_play", "road_rest", "steering_play", "trail", "loss", "loss_time",
    "patch_from", "patch_to", "patch_depth", "patch_edge", "grip",
)  # fmt: skip
AT = {name: i for i, name in enumerate(NAMES)}
(
    LOAD, ALPHA, KAPPA, RADIUS, START, DELAY, SPEED, STEP_AT, LENGTH,
    ROAD_PLAY, ROAD_REST, STEERING_PLAY, TRAIL, LOSS, LOSS_TIME,
    PATCH_FROM, PATCH_TO, PATCH_DEPTH, PATCH_EDGE, GRIP,
) = range(20)  # fmt: skip
OUT = ("plank", "wheel", "fx", "fy", "load")
SAMPLE, SUB = 0.05, 2
"""sampling time of the table [s], steps per sample"""
STOP, PLATE_DRAG, PLATE_RUB = 1.0e8, 6.0e4, 9.0
"""stop stiffness [N/m], damping [N s/m] and friction [N] of the plate on its supports"""
STEER_STOP, STEER_DRAG, STEER_RUB = 4.0e5, 2.0e3, 2.0
"""stop stiffness [N m/rad], damping [N m s/rad] and friction [N m] of the steering"""


@njit(cache=True, nogil=True)
def between_stops(at, gap, push, rub, drag, stop, h):
    """Position of a part with friction and damping under a force, with springs beyond the gap."""
    if gap <= 0.0:
        return 0.0
    end = 0.5 * gap
    inside = min(max(at, -end), end)
    drive = push - stop * (at - inside)
    if abs(drive) <= rub and at == inside:
        return at
    drive -= math.copysign(min(rub, abs(drive)), drive)
    stiff = stop if at != inside else 0.0
    new = at + drive / (drag / h + stiff)
    # no further than where the stop balances the force
    return min(max(new, -end - abs(push) / stop), end + abs(push) / stop)


@njit(cache=True, nogil=True)
def worn(p, x):
    """Remaining grip at a position of the plank."""
    if p[PATCH_DEPTH] == 0.0:
        return 1.0
    rise = 1.0 / (1.0 + math.exp(-(x - p[PATCH_FROM]) / p[PATCH_EDGE]))
    fall = 1.0 / (1.0 + math.exp((x - p[PATCH_TO]) / p[PATCH_EDGE]))
    return 1.0 - p[PATCH_DEPTH] * rise * fall


@njit(cache=True, nogil=True)
def run_one(p, tire, bumps, out):
    """Simulate one run from standstill; out: shape (len(OUT), samples); returns the number of
    samples."""
    h = SAMPLE / SUB
    state, feet, press = np.zeros(7), np.zeros((MOST, 3)), np.zeros(MOST)
    newest = 0
    plank = wheel = lost = steer = since = 0.0
    plate = 0.5 * p[ROAD_REST] * p[ROAD_PLAY]
    for n in range(out.shape[1] * SUB):
        t = n * h
        fx, fy = state[5], state[6]
        travel = p[SPEED] * h * (1.0 - math.exp(-((max(t - 0.4, 0.0) / 0.11) ** 2)))
        plank += travel
        late = max(t - 0.4 - p[DELAY], 0.0)
        if plank > p[STEP_AT]:
            since += h
        slip = p[KAPPA] * (1.0 - math.exp(-since / 0.04))
        turned = p[SPEED] * math.cos(p[ALPHA]) * h * (1.0 - math.exp(-((late / 0.11) ** 2)))
        turned *= 1.0 + slip
        wheel += turned / p[RADIUS]
        before = plate
        plate = between_stops(plate, p[ROAD_PLAY], fx, PLATE_RUB, PLATE_DRAG, STOP, h)
        steer = between_stops(
            steer, 2.0 * p[STEERING_PLAY], p[TRAIL] * fy, STEER_RUB, STEER_DRAG, STEER_STOP, h
        )
        road = travel + plate - before
        # a side force behind the steering axis turns the wheel into the direction of the road
        side = p[ALPHA] + steer
        lost += (p[LOSS] * min(fx, 0.0) - lost) * (1.0 - math.exp(-h / p[LOSS_TIME]))
        load = p[LOAD] + lost + bumps[0] * math.sin(plank / 0.15 + bumps[1])
        load += bumps[2] * math.sin(plank / 0.061 + bumps[3])
        newest = step(
            state, feet, press, newest, tire, load, p[GRIP] * worn(p, plank), turned,
            turned - road * math.cos(side), -road * math.sin(side), h,
        )  # fmt: skip
        if n % SUB == SUB - 1:
            i = n // SUB
            out[0, i], out[1, i] = plank, wheel
            out[2, i], out[3, i], out[4, i] = state[5], state[6], load
            if plank > p[LENGTH]:
                return i + 1
    return out.shape[1]
