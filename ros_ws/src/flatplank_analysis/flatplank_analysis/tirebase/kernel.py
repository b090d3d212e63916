# SPDX-License-Identifier: Apache-2.0
"""One step of the contact-patch model over a node, compiled; (7.13)-(7.20) with the patch mass
quasi-static, driven by increments of travel.

    patch travel W(k) + d(deflection of carcass, play, creep) = slip travel dw

The contact slip k follows the slip of the patch with two states over the travel (ds + ns dw):
(1 + w x/6) / (1 + x/2 + w x^2/12), x = 2 sigma_c d/ds. w = 0 is the first order of the thesis,
(7.16); w = 1 has the mean delay 2/3 sigma_c and the short-wave stiffness of a row of bristles.

In the steady state k = kappa/(1 + ns kappa): ns = 0 is the thesis's form, ns = 1 a patch whose
bristles run through the contact with the wheel. While the carcass deflects, the bristles still
run through with the whole wheel, so it is dw, not the slip of the patch, that stands beside ds.

The carcass feels the change of the steady force, so load and friction enter with their rate.
"""

from __future__ import annotations

import numpy as np
from numba import njit

#: columns of the parameter block, one row per lane and run
NAMES = (
    "stiff", "peak", "shape", "fall", "round", "denom", "carcass", "half", "tread",
    "asym_peak", "asym_stiff", "play", "play_at", "play_soft", "give", "soften",
    "creep", "creep_time", "slide", "follow", "combine", "loss_brake", "loss_drive",
    "play_rest", "memory", "turn", "feel", "swing", "rotate",
    "law_0", "law_1", "law_2", "law_3", "law_4", "law_5", "law_6", "law_7",
)  # fmt: skip
(
    STIFF, PEAK, SHAPE, FALL, ROUND, DENOM, CARCASS, HALF, TREAD,
    ASYM_PEAK, ASYM_STIFF, PLAY, PLAY_AT, PLAY_SOFT, GIVE, SOFTEN,
    CREEP, CREEP_TIME, SLIDE, FOLLOW, COMBINE, LOSS_BRAKE, LOSS_DRIVE,
    PLAY_REST, MEMORY, TURN, FEEL, SWING, ROTATE, LAW,
) = range(30)  # fmt: skip
WIDTH = len(NAMES)
LAW_LEVELS = (0.1, 0.05, 0.02, 0.009)
"""contact slips of the free law; negative first, falling, then positive, rising"""

FAST = dict(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
"""no checks for division by zero; what is not finite is found by the engine"""

SLIDING = 0.08
"""adhesion share that is left to a sliding patch"""


@njit(**FAST)
def saturation(x, shape, fall, rounding):
    """Force over its peak at x = K|k|/peak, its slope, and the part of it that sticks.

    Saturation 1 - (1 - y/n)^n: n = 3 is the brush with a parabolic pressure, n = 2 with a uniform
    one; `fall` lets the force drop beyond the peak. What sticks is slope times slip, as in a
    brush; the rest slides. Outside the patch models the curve is one family, not a physical
    claim.
    """
    # `rounding` takes out the term of second order: 1 starts like a sine, 0 like a brush
    b = rounding * (shape - 1.0) / (2.0 * shape)
    y = x + b * x * x / (1.0 + 0.5 * x)
    dy = 1.0 + b * x * (2.0 + 0.5 * x) / (1.0 + 0.5 * x) ** 2
    if y < shape:
        t = 1.0 - y / shape
        slope = t ** (shape - 1.0)
        level = 1.0 - slope * t
    else:
        slope = 0.0
        level = 1.0
    n2 = shape * shape
    bend = y * y / (y * y + n2)
    dbend = 2.0 * y * n2 / (y * y + n2) ** 2
    factor = 1.0 - fall * bend
    return level * factor, dy * (slope * factor - level * fall * dbend), y * slope * factor


@njit(**FAST)
def steady(k, stiff, peak, shape, fall, rounding):
    """Steady force [N] at contact slip k and its slope dF/dk, without slip across."""
    level, slope, _ = saturation(stiff * abs(k) / peak, shape, fall, rounding)
    return (peak * level if k >= 0.0 else -peak * level), stiff * slope


@njit(**FAST)
def shared(k, across, stiff, peak, stiff_across, peak_across, p):
    """Steady force [N] at contact slip k beside a slip `across`, on one friction ellipse.

    What sticks pulls along the bent rubber. What slides turns from there into the direction of the
    slip: by the share `swing` at once, the rest with the size of the slip (`rotate`).
    """
    bent, bent_across = stiff * k / peak, stiff_across * across / peak_across
    x = (bent * bent + bent_across * bent_across) ** 0.5
    if x == 0.0:
        return 0.0
    level, _, stuck = saturation(x, p[SHAPE], p[FALL], p[ROUND])
    way, way_across = k / peak, across / peak_across
    along = way / (way * way + way_across * way_across) ** 0.5
    late = p[ROTATE] * x * x
    share = (p[SWING] + late) / (1.0 + late) * (level - stuck)
    return peak * ((level - share) * bent / x + share * along)


@njit(**FAST)
def free_law(k, p):
    """Factor on the force at a contact slip and its slope: straight pieces over |k|."""
    first = LAW if k < 0.0 else LAW + 4
    any_law = False
    for i in range(4):
        if p[first + i] != 0.0:
            any_law = True
    if not any_law:
        return 1.0, 0.0
    size = abs(k)
    # heights from the largest slip to the smallest
    if k < 0.0:
        h0, h1, h2, h3 = p[LAW], p[LAW + 1], p[LAW + 2], p[LAW + 3]
    else:
        h3, h2, h1, h0 = p[LAW + 4], p[LAW + 5], p[LAW + 6], p[LAW + 7]
    if size >= LAW_LEVELS[0]:
        return 1.0 + h0, 0.0
    if size < LAW_LEVELS[3]:
        return 1.0 + h3, 0.0
    if size >= LAW_LEVELS[1]:
        a, b, ha, hb = LAW_LEVELS[1], LAW_LEVELS[0], h1, h0
    elif size >= LAW_LEVELS[2]:
        a, b, ha, hb = LAW_LEVELS[2], LAW_LEVELS[1], h2, h1
    else:
        a, b, ha, hb = LAW_LEVELS[3], LAW_LEVELS[2], h3, h2
    slope = (hb - ha) / (b - a)
    sign = -1.0 if k < 0.0 else 1.0
    return 1.0 + ha + slope * (size - a), slope * sign


@njit(**FAST)
def strengths(k, load, friction, p, nominal, speed_ratio):
    """Slip stiffness and peak force [N] with load, friction, asymmetry, sliding speed taken in."""
    peak = p[PEAK] * friction * load
    stiff = p[STIFF] * (1.0 + p[FEEL] * (load / nominal - 1.0))
    if k < 0.0:
        peak *= 1.0 - p[ASYM_PEAK]
        stiff *= 1.0 - p[ASYM_STIFF]
    if p[SLIDE] != 0.0:
        ratio = abs(k) * speed_ratio / 0.05
        peak *= 1.0 - p[SLIDE] * ratio / (1.0 + ratio)
    return stiff, peak


@njit(**FAST)
def tire_force(k, load, friction, p, nominal, speed_ratio, across, other):
    """Force and slope at a contact slip; across: the slip in the other direction, whose numbers
    are `other`."""
    stiff, peak = strengths(k, load, friction, p, nominal, speed_ratio)
    if across == 0.0:
        force, slope = steady(k, stiff, peak, p[SHAPE], p[FALL], p[ROUND])
    else:
        more = strengths(across, load, friction, other, nominal, speed_ratio)
        force = shared(k, across, stiff, peak, more[0], more[1], p)
        near = shared(k + 1e-6, across, stiff, peak, more[0], more[1], p)
        slope = (near - force) * 1e6
    change, turn = free_law(k, p)
    return force * change, slope * change + force * turn


@njit(**FAST)
def whole_slip(k, across, p, other):
    """Size of the slip of which |k| is a part, in units of this direction."""
    if across == 0.0:
        return abs(k)
    scale = other[STIFF] * p[PEAK] / (p[STIFF] * other[PEAK])
    return (k * k + (scale * across) ** 2) ** 0.5


@njit(**FAST)
def deflection(force, p):
    """Deflection of carcass and play at a force [m], and its slope."""
    c = p[CARCASS]
    soft = 1.0 + p[SOFTEN] * abs(force) / 4000.0
    value = force * soft / c
    slope = (2.0 * soft - 1.0) / c
    if p[PLAY] != 0.0:
        x = (force - p[PLAY_AT]) / p[PLAY_SOFT]
        root = (1.0 + x * x) ** 0.5
        value += 0.5 * p[PLAY] * x / root
        slope += 0.5 * p[PLAY] / (p[PLAY_SOFT] * root * root * root)
    return value, slope


@njit(**FAST)
def start_deflection(p):
    """Deflection at standstill: the plank rests somewhere in its play."""
    value, _ = deflection(0.0, p)
    return value + 0.5 * p[PLAY] * p[PLAY_REST]


@njit(**FAST)
def patch_length(k, whole, theta, half):
    """Relaxation length of the patch (7.17), (7.18) [m]; whole: size of the slip."""
    near = whole / (1.0 + k) if k > -0.5 else 2.0 * whole
    # a smooth lower limit: with (7.18) as it is a sliding patch would vibrate from node to node
    free = 1.0 - theta * near
    m = SLIDING + 0.5 * (1.0 - SLIDING) * (free + (free * free + 0.04) ** 0.5)
    return m * half / (1.0 + max(k, -0.5))


@njit(**FAST)
def advance(old, ds, dw, dt, load, friction, p, nominal, ratio, across, other):
    """State (slip, force, deflection, creep, slope of the law, patch rate) after one node.

    across: slip in the other direction, as far as the two share the friction; other: the numbers
    of that direction.
    """
    k0, f0, x0, creep0, slope0, r0 = old
    if p[LOSS_BRAKE] != 0.0 or p[LOSS_DRIVE] != 0.0:
        loss = p[LOSS_BRAKE] * min(f0, 0.0) + p[LOSS_DRIVE] * max(f0, 0.0)
        load = load * (1.0 + loss / nominal)
    dw = dw - (p[GIVE] * f0 + p[FOLLOW] * f0 / (f0 * f0 + 900.0) ** 0.5) * ds
    creep = creep0
    if p[CREEP] != 0.0:
        aim = p[CREEP] * f0 / p[CARCASS]
        creep = aim + (creep0 - aim) * np.exp(-dt / p[CREEP_TIME])
        dw = dw - (creep - creep0)
    ds = max(ds + p[DENOM] * dw, 0.0)
    alpha, gamma = p[MEMORY] / 6.0, p[MEMORY] / 12.0
    # (7.19) with the tread stiffness tied to the slip stiffness
    theta = p[TREAD] * p[STIFF] / (3.0 * p[PEAK] * friction * nominal)
    half = p[HALF] * (1.0 + 0.6 * (load / nominal - 1.0))
    sigma = patch_length(k0, whole_slip(k0, across, p, other), theta, half)
    late = 0.5
    if ds > 0.0:
        late = max(0.5, 1.0 - (sigma + max(slope0, 0.0) / p[CARCASS]) / ds)
    fk, xk, slope = f0, x0, slope0
    low, high = -1.0e3, 1.0e3
    t = 2.0 * sigma
    # first guess: the law and the patch go on as they went
    under = alpha * t + late * ds
    rise = gamma * t * t + 0.5 * late * ds * t
    patch = (late * ds * ds * k0 - ds * t * r0) / under
    stiff = (rise + late * late * ds * ds) / under
    k1 = k0 + (dw - patch) / (stiff + max(slope0, 0.0) / p[CARCASS])
    # safeguarded Newton: the left side grows with k1 as long as the law does not fall steeply
    for _ in range(60):
        t = sigma + patch_length(k1, whole_slip(k1, across, p, other), theta, half)
        under = alpha * t + late * ds
        rise = gamma * t * t + 0.5 * late * ds * t
        patch = (
            rise * (k1 - k0) - ds * t * r0 + late * ds * ds * (late * k1 + (1.0 - late) * k0)
        ) / under
        fk, slope = tire_force(k1, load, friction, p, nominal, ratio, across, other)
        xk, flex = deflection(fk, p)
        miss = patch + xk - x0 - dw
        if miss > 0.0:
            high = k1
        else:
            low = k1
        stiff = (rise + late * late * ds * ds) / under
        trial = k1 - miss / (stiff + max(slope, 0.0) * flex)
        # halve only between two known ends; a miss of exactly zero is no reason to leave
        if (trial < low or trial > high) and low > -1.0e3 and high < 1.0e3:
            trial = 0.5 * (low + high)
        move = trial - k1
        k1 = trial
        if abs(move) < 1e-6:
            # the last step is so small that everything follows its slope
            fk += slope * move
            xk += slope * flex * move
            patch += stiff * move
            break
    r1 = r0 - 0.5 * (k1 - k0) + (patch - ds * (late * k1 + (1.0 - late) * k0)) / t
    return k1, fk, xk, creep, slope, r1


@njit(**FAST)
def one_node(state, ds, dw, dt, load, friction, params, nominal, speed):
    """One node of all elements in x (axis 0 index 0) and y (1).

    state (6, 2, elements) is updated in place; dw (2, elements); params (2, elements, WIDTH).
    """
    for e in range(ds.shape[0]):
        rate = abs(ds[e]) / dt[e] / speed if dt[e] > 0.0 else 0.0
        ky = state[0, 1, e]
        slip = dw[0, e] - params[0, e][GIVE] * state[1, 0, e] * ds[e]
        for axis in range(2):
            p = params[axis, e]
            kc = ky if axis == 0 else state[0, 0, e]
            other = params[1 - axis, e]
            old = (
                state[0, axis, e], state[1, axis, e], state[2, axis, e],
                state[3, axis, e], state[4, axis, e], state[5, axis, e],
            )  # fmt: skip
            way = ds[e] + p[TURN] * slip if axis == 1 else ds[e]
            new = advance(
                old, way, dw[axis, e], dt[e], load[e], friction[e], p, nominal[e], rate,
                p[COMBINE] * kc, other,
            )  # fmt: skip
            for i in range(6):
                state[i, axis, e] = new[i]


@njit(**FAST)
def rest(params):
    """State at standstill without force, shape (6, 2, elements)."""
    state = np.zeros((6, 2, params.shape[1]))
    for axis in range(2):
        for e in range(params.shape[1]):
            state[2, axis, e] = start_deflection(params[axis, e])
    return state


@njit(**FAST)
def sweep(ds, dw, dt, load, friction, params, nominal, speed, todo, force, first, last):
    """All nodes of elements first..last; inputs (elements, samples), dw and force (2, e, s).

    todo (2, elements) says which directions are wanted; they need each other only where the
    slips are combined.
    """
    for e in range(first, last):
        px, py = params[0, e], params[1, e]
        both = px[COMBINE] != 0.0 or py[COMBINE] != 0.0 or py[TURN] * px[GIVE] != 0.0
        do_x = todo[0, e] or both
        do_y = todo[1, e] or both
        x = (0.0, 0.0, start_deflection(px), 0.0, 0.0, 0.0)
        y = (0.0, 0.0, start_deflection(py), 0.0, 0.0, 0.0)
        for n in range(ds.shape[1]):
            step, s, w, mu = dt[e, n], ds[e, n], load[e, n], friction[e, n]
            rate = abs(s) / step / speed if step > 0.0 else 0.0
            # the rubber goes through the contact with the wheel, in both directions
            way = s + py[TURN] * (dw[0, e, n] - px[GIVE] * x[1] * s)
            if do_x:
                x = advance(
                    x, s, dw[0, e, n], step, w, mu, px, nominal[e], rate, px[COMBINE] * y[0], py
                )
                force[0, e, n] = x[1]
            if do_y:
                y = advance(
                    y, way, dw[1, e, n], step, w, mu, py, nominal[e], rate, py[COMBINE] * x[0], px
                )
                force[1, e, n] = y[1]
