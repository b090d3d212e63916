# SPDX-License-Identifier: Apache-2.0
"""Laws of one element of the contact-patch model, compiled: steady force, relaxation length, play.

They have no branches, so that loops over elements stay loops of vectors.
"""

from __future__ import annotations

import math

from flatplank_analysis.contact_patch.compiling import choose, inline, power

LAW_LEVELS = (0.009, 0.02, 0.05, 0.1)
"""size of the contact slip at the nodes of the free law"""
SLIDING = 0.08
"""least adhesion share of the patch in (7.18)"""
START_STEPS = 6
"""Newton steps for the slip of a force at rest"""
HELD = 0.9
"""largest force at rest, as a share of the peak: beyond it the slip is ill-determined"""


@inline
def saturation(x, shape, fall, bend):
    """Normalised force at x = K|k|/peak, its slope, and its sticking part.

    Saturation 1 - (1 - y/n)^n: n = 3 is the brush with a parabolic pressure, n = 2 with a uniform
    one; `fall` lets the force drop beyond the peak. The sticking part is slope times slip, as in a
    brush; the rest slides. Between the brush models the curve is an empirical family. `bend`
    removes the term of second order.
    """
    under = 1.0 + 0.5 * x
    y = x + bend * x * x / under
    dy = 1.0 + bend * x * (2.0 + 0.5 * x) / (under * under)
    t = max(1.0 - y / shape, 0.0)
    slope = power(max(t, 1e-290), shape - 1.0)
    slope = choose(t > 0.0, slope, 0.0)
    level = 1.0 - slope * t
    n2 = shape * shape
    over = 1.0 / (y * y + n2)
    factor = 1.0 - fall * y * y * over
    drop = level * fall * 2.0 * y * n2 * over * over
    return level * factor, dy * (slope * factor - drop), y * slope * factor


@inline
def steady(k, stiff, peak, shape, fall, bend):
    """Steady force [N] at contact slip k and its slope dF/dk, without slip across."""
    level, slope, _ = saturation(stiff * abs(k) / peak, shape, fall, bend)
    force = peak * level
    return choose(k >= 0.0, force, -force), stiff * slope


@inline
def shared(k, stiff, peak, bent_across, way_across, shape, fall, bend, turn_share, turn_rate):
    """Steady force [N] at contact slip k with slip in the other direction, on a friction ellipse.

    The sticking part acts along the deflection of the rubber. The sliding part turns from there
    towards the slip: the share `turn_share` at once, the rest with the square of the slip
    (`turn_rate`).
    """
    bent, way = stiff * k / peak, k / peak
    x = math.sqrt(bent * bent + bent_across * bent_across)
    level, _, stuck = saturation(x, shape, fall, bend)
    along = way / math.sqrt(way * way + way_across * way_across)
    late = turn_rate * x * x
    share = (turn_share + late) / (1.0 + late) * (level - stuck)
    force = peak * ((level - share) * bent / x + share * along)
    return choose(x > 0.0, force, 0.0)


@inline
def piece(size, near, far, low, high):
    """Contribution of a linear piece of the law from slip `near` to `far`, and its slope."""
    slope = (high - low) / (far - near)
    inside = min(max(size, near), far) - near
    # a slip at the far end belongs to the next piece
    return slope * inside, choose(size >= near, choose(size < far, slope, 0.0), 0.0)


@inline
def free_law(k, h0, h1, h2, h3):
    """Factor on the force at a contact slip, and its slope: piecewise linear over |k|, heights
    from the smallest slip to the largest."""
    size = abs(k)
    a, slope_a = piece(size, LAW_LEVELS[0], LAW_LEVELS[1], h0, h1)
    b, slope_b = piece(size, LAW_LEVELS[1], LAW_LEVELS[2], h1, h2)
    c, slope_c = piece(size, LAW_LEVELS[2], LAW_LEVELS[3], h2, h3)
    slope = slope_a + slope_b + slope_c
    return 1.0 + h0 + a + b + c, choose(k < 0.0, -slope, slope)


@inline
def slipping(k, peak, slide, speed_ratio):
    """Peak force at the sliding speed."""
    ratio = abs(k) * speed_ratio / 0.05
    return peak * (1.0 - slide * ratio / (1.0 + ratio))


@inline
def play_position(force, play, at, soft, hold, last):
    """Position in the play of the bench at a force [m], and its slope.

    It moves at the force `at`. Dry friction `hold` [N] keeps it at its last position until the
    force exceeds that range: one curve per direction, and the region between them.
    """
    x, y = (force - at - hold) / soft, (force - at + hold) / soft
    root, other = math.sqrt(1.0 + x * x), math.sqrt(1.0 + y * y)
    up, down = 0.5 * play * x / root, 0.5 * play * y / other
    place = max(up, min(down, last))
    rate = choose(up >= last, 1.0 / (root * root * root), 0.0)
    rate = choose(down <= last, 1.0 / (other * other * other), rate)
    return place, 0.5 * play / soft * rate


@inline
def patch_length(k, whole, theta, half, plank):
    """Relaxation length of the patch (7.17), (7.18) [m] over the travel `ds + ns dw`.

    whole: size of the slip; plank: 1 - ns along the wheel, 0 across it. The two formulas hold over
    the travel of the plank, ns = 0. Over that of the wheel, ns = 1, the length of a row of
    bristles does not depend on the sign of the slip, and across the wheel it never does.
    """
    under = 1.0 + plank * max(k, -0.5)
    # a smooth lower limit: with (7.18) itself a sliding patch would oscillate from node to node
    free = 1.0 - theta * whole / under
    m = SLIDING + 0.5 * (1.0 - SLIDING) * (free + math.sqrt(free * free + 0.04))
    return m * half / under


@inline
def fallen(slope, flex):
    """What a falling law adds to the relaxation length of the patch [m].

    Where the force falls as the slip grows, the carcass shortens that length. Below zero the slip
    jumps from node to node.
    """
    return max(-slope, 0.0) * flex


@inline
def softened(force, soften):
    """Factor on the carcass deflection at a force."""
    return 1.0 + soften * abs(force) / 4000.0


@inline
def slip_of(force, stiff, peak, shape, fall, bend):
    """Contact slip whose steady force is `force` [N], and the slope there; up to HELD peaks."""
    wanted = max(-HELD * peak, min(HELD * peak, force))
    k, slope = wanted / stiff, stiff
    for _ in range(START_STEPS):
        there, slope = steady(k, stiff, peak, shape, fall, bend)
        k = k + (wanted - there) / max(slope, 0.01 * stiff)
    return k, slope, wanted
