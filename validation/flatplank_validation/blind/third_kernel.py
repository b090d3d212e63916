# SPDX-License-Identifier: Apache-2.0
"""A third tire, compiled: threads of rubber between belt and road, on a carcass with damping.

A thread enters at the front of the contact with each piece of belt that comes in, and keeps its
two ends: the root on the belt, the foot on the road. Its force is anisotropic in the shift between
them. The foot creeps along the force as soon as that is more than the grip. The pressure is an
ellipse that leans forwards; the grip depends on the mean pressure and on how fast the foot slides,
and is not the same along and across. The carcass is a spring with a damper in each direction,
stepped in time. ISO W axes, SI.
"""

from __future__ import annotations

import math

from numba import njit

#: numbers of the tire, in the order in which the kernel gets them
NAMES = (
    "vertical", "radius", "share", "grip_x", "grip_y", "thin", "width", "thread_x", "thread_y",
    "forward", "lost", "slow", "piece", "carcass_x", "carcass_y", "damper_x", "damper_y",
)  # fmt: skip
AT = {name: i for i, name in enumerate(NAMES)}
(
    VERTICAL, RIM, SHARE, GRIP_X, GRIP_Y, THIN, BREADTH, THREAD_X, THREAD_Y,
    FORWARD, LOST, SLOW, PIECE, CARCASS_X, CARCASS_Y, DAMPER_X, DAMPER_Y,
) = range(17)  # fmt: skip
MOST = 256
"""threads kept in a ring"""
REFERENCE = 3.0e5
"""[Pa] pressure at which the grip is stated"""
TRAILING = 0.25
"""share of the sliding speed that is new in a step"""


@njit(cache=True, nogil=True)
def contact_of(load, tire):
    """Half contact length [m], grip along and across, at a load [N]."""
    sink = load / tire[VERTICAL]
    # chord of a circle that is pressed in; the belt lifts off before the chord ends
    half = tire[SHARE] * math.sqrt(sink * (2.0 * tire[RIM] - sink))
    pressure = load / (math.pi * half * tire[BREADTH])
    fall = 1.0 - tire[THIN] * math.log(pressure / REFERENCE)
    return half, tire[GRIP_X] * fall, tire[GRIP_Y] * fall


@njit(cache=True, nogil=True)
def creep(tx, ty, cx, cy, gx, gy, limit):
    """How far a foot creeps along the force (tx, ty) until that is no more than the grip [m].

    Forces are measured by the grip in their direction, the force falls by the stiffness.
    """
    size = math.sqrt(tx * tx + ty * ty)
    nx, ny = tx / size, ty / size
    ux, uy = tx / gx, ty / gy
    wx, wy = cx * nx / gx, cy * ny / gy
    a = wx * wx + wy * wy
    b = ux * wx + uy * wy
    root = b * b - a * (ux * ux + uy * uy - limit * limit)
    # the nearest point when the line passes the ellipse by
    d = (b - math.sqrt(max(root, 0.0))) / a
    return nx * d, ny * d


@njit(cache=True, nogil=True)
def patch(feet, press, state, newest, half, load, tire, gx, gy, h, move):
    """Force of all threads [N] and the stiffness of those that hold [N/m].

    feet (MOST, 3): where a thread hangs straight, speed of its foot; with `move` the feet creep.
    press (MOST): room to work in.
    """
    piece = tire[PIECE]
    cx, cy = tire[THREAD_X] * piece, tire[THREAD_Y] * piece
    count = int(2.0 * half / piece) + 3
    whole = 0.0
    for i in range(count):
        # a thread counts for the part of its piece that is in the contact
        at = half - (state[4] - (newest + 1 - i) * piece)
        part = min(max((half - abs(at)) / piece + 0.5, 0.0), 1.0)
        place = at / half
        press[i] = part * math.sqrt(max(1.0 - place * place, 1e-4))
        press[i] *= 1.0 + tire[FORWARD] * place
        whole += press[i]
    fx = fy = sx = sy = 0.0
    for i in range(count):
        at = half - (state[4] - (newest + 1 - i) * piece)
        part = min(max((half - abs(at)) / piece + 0.5, 0.0), 1.0)
        if part == 0.0:
            continue
        k = (newest + 1 - i) % MOST
        tx = cx * part * (state[2] - feet[k, 0])
        ty = cy * part * (state[3] - feet[k, 1])
        hold = 1.0 - tire[LOST] * (1.0 - math.exp(-feet[k, 2] / tire[SLOW]))
        limit = hold * load * press[i] / whole
        speed = 0.0
        if (tx / gx) ** 2 + (ty / gy) ** 2 > limit * limit:
            dx, dy = creep(tx, ty, cx * part, cy * part, gx, gy, limit)
            tx -= cx * part * dx
            ty -= cy * part * dy
            # across the force a sliding thread still holds
            size = tx * tx + ty * ty + 1e-12
            sx += cx * part * ty * ty / size
            sy += cy * part * tx * tx / size
            speed = math.sqrt(dx * dx + dy * dy) / h
            if move:
                feet[k, 0] += dx
                feet[k, 1] += dy
        else:
            sx += cx * part
            sy += cy * part
        if move:
            feet[k, 2] += TRAILING * (speed - feet[k, 2])
        fx += tx
        fy += ty
    return fx, fy, sx, sy


@njit(cache=True, nogil=True)
def enter(feet, before, newest, tire, state, gone_x, gone_y):
    """Threads that come in at the front, their feet where the belt was then."""
    piece = tire[PIECE]
    # one piece ahead of the contact, so that a thread may come in bit by bit
    while (newest + 1) * piece <= state[4]:
        newest += 1
        part = (state[4] - newest * piece) / max(state[4] - before, 1e-12)
        k = (newest + 1) % MOST
        feet[k, 0], feet[k, 1] = state[2] - part * gone_x, state[3] - part * gone_y
        feet[k, 2] = 0.0
    # what lies ahead of the contact is not bent yet
    k = (newest + 1) % MOST
    share = min(max((state[4] - (newest + 0.5) * piece) / piece, 0.0), 1.0)
    feet[k, 0] += (1.0 - share) * gone_x
    feet[k, 1] += (1.0 - share) * gone_y
    return newest


@njit(cache=True, nogil=True)
def step(state, feet, press, newest, tire, load, grip, rolled, slip_x, slip_y, h):
    """One step of the tire; returns the number of the newest thread.

    state: carcass x, y, shift of the belt x, y, its travel [m], force x, y [N]. slip_x, slip_y:
    how far the rim moves against the road [m].
    """
    half, gx, gy = contact_of(load, tire)
    gx, gy = gx * grip, gy * grip
    before = state[4]
    state[4] += rolled
    state[2] += slip_x
    state[3] += slip_y
    fx, fy, sx, sy = patch(feet, press, state, newest, half, load, tire, gx, gy, h, False)
    # the carcass gives way: linearly implicit in the threads that hold
    ax = (fx - tire[CARCASS_X] * state[0]) / (sx + tire[CARCASS_X] + tire[DAMPER_X] / h)
    ay = (fy - tire[CARCASS_Y] * state[1]) / (sy + tire[CARCASS_Y] + tire[DAMPER_Y] / h)
    state[0] += ax
    state[1] += ay
    state[2] -= ax
    state[3] -= ay
    newest = enter(feet, before, newest, tire, state, slip_x - ax, slip_y - ay)
    fx, fy, sx, sy = patch(feet, press, state, newest, half, load, tire, gx, gy, h, True)
    state[5], state[6] = fx, fy
    return newest
