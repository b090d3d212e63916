# SPDX-License-Identifier: Apache-2.0
"""Kernel of the third tire: rubber threads between belt and road, on a carcass with damping.

A thread enters the contact at the front with each piece of belt. Its root is fixed to the belt,
its foot touches the road. The force is anisotropic in the shift between the two. The foot creeps
along the force when the force exceeds the grip. The pressure is an ellipse shifted forward. Grip
depends on the mean pressure and the sliding speed of the foot, and differs along and across. The
carcass is a spring and damper in each direction, integrated in time. ISO W axes, SI units.
"""

from __future__ import annotations

import math

from numba import njit

#: parameters of the tire, in the order in which the kernel gets them
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
"""number of threads in the ring buffer"""
REFERENCE = 3.0e5
"""reference pressure of the grip [Pa]"""
TRAILING = 0.25
"""weight of the new sliding speed in a step (low-pass) [-]"""


@njit(cache=True, nogil=True)
def contact_of(load, tire):
    """Half contact length [m], grip along and across, at a load [N]."""
    sink = load / tire[VERTICAL]
    # chord of a deflected circle; the belt lifts off before the end of the chord
    half = tire[SHARE] * math.sqrt(sink * (2.0 * tire[RIM] - sink))
    pressure = load / (math.pi * half * tire[BREADTH])
    fall = 1.0 - tire[THIN] * math.log(pressure / REFERENCE)
    return half, tire[GRIP_X] * fall, tire[GRIP_Y] * fall


@njit(cache=True, nogil=True)
def creep(tx, ty, cx, cy, gx, gy, limit):
    """Creep of a foot along the force (tx, ty) until the force equals the grip [m].

    Forces are scaled by the grip in their direction; the stiffness reduces the force.
    """
    size = math.sqrt(tx * tx + ty * ty)
    nx, ny = tx / size, ty / size
    ux, uy = tx / gx, ty / gy
    wx, wy = cx * nx / gx, cy * ny / gy
    a = wx * wx + wy * wy
    b = ux * wx + uy * wy
    root = b * b - a * (ux * ux + uy * uy - limit * limit)
    # the nearest point when the line misses the ellipse
    d = (b - math.sqrt(max(root, 0.0))) / a
    return nx * d, ny * d


@njit(cache=True, nogil=True)
def patch(feet, press, state, newest, half, load, tire, gx, gy, h, move):
    """Force of all threads [N], and stiffness of the sticking ones [N/m].

    feet (MOST, 3): belt shift at zero deflection of a thread, speed of its foot; with `move` the
    feet creep. press (MOST): work space.
    """
    piece = tire[PIECE]
    cx, cy = tire[THREAD_X] * piece, tire[THREAD_Y] * piece
    count = int(2.0 * half / piece) + 3
    whole = 0.0
    for i in range(count):
        # a thread is weighted with the part of its piece that is in contact
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
            # a sliding thread keeps its stiffness across the force
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
    """Add threads that enter at the front, with feet at the belt position at that time."""
    piece = tire[PIECE]
    # one piece ahead of the contact, so that a thread enters gradually
    while (newest + 1) * piece <= state[4]:
        newest += 1
        part = (state[4] - newest * piece) / max(state[4] - before, 1e-12)
        k = (newest + 1) % MOST
        feet[k, 0], feet[k, 1] = state[2] - part * gone_x, state[3] - part * gone_y
        feet[k, 2] = 0.0
    # threads ahead of the contact have no deflection yet
    k = (newest + 1) % MOST
    share = min(max((state[4] - (newest + 0.5) * piece) / piece, 0.0), 1.0)
    feet[k, 0] += (1.0 - share) * gone_x
    feet[k, 1] += (1.0 - share) * gone_y
    return newest


@njit(cache=True, nogil=True)
def step(state, feet, press, newest, tire, load, grip, rolled, slip_x, slip_y, h):
    """One step of the tire; returns the number of the newest thread.

    state: carcass x, y, shift of the belt x, y, its travel [m], force x, y [N]. slip_x, slip_y:
    motion of the rim relative to the road [m].
    """
    half, gx, gy = contact_of(load, tire)
    gx, gy = gx * grip, gy * grip
    before = state[4]
    state[4] += rolled
    state[2] += slip_x
    state[3] += slip_y
    fx, fy, sx, sy = patch(feet, press, state, newest, half, load, tire, gx, gy, h, False)
    # deflection of the carcass: linearly implicit in the sticking threads
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
