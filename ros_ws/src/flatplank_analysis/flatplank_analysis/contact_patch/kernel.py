# SPDX-License-Identifier: Apache-2.0
"""One step of the contact-patch model over a node, compiled; (7.13)-(7.20) with the patch mass
quasi-static, driven by increments of travel.

    patch travel W(k) + d(deflection of carcass, play, creep) = slip travel dw

The contact slip k follows the slip of the patch with two states over the travel (ds + ns dw):
(1 + w x/6) / (1 + x/2 + w x^2/12), x = 2 sigma_c d/ds. w = 0 is the first order of the thesis,
(7.16); w = 1 has the mean delay 2/3 sigma_c and the short-wave stiffness of a row of bristles.

In the steady state k = kappa/(1 + ns kappa): ns = 0 is the thesis's form, ns = 1 a patch whose
bristles move through the contact with the wheel. While the carcass deflects, the bristles still
move with the whole wheel, so dw is added to ds, not the slip of the patch.

The carcass deflects with the change of the steady force, so the rates of load and friction matter,
and the relaxation length falls with the slope of the force law. The share `fixed_length` of the
deflection follows the slip instead, as with a law that is a straight line: with 1 the relaxation
length is the same at every slip.

An element is one run of one parameter set. Elements are computed in blocks of `WIDE` as a table
with one row per quantity and one column per element. Loops over the columns have no branches, so
that the compiler computes several elements at once.
"""

from __future__ import annotations

import math

import numpy as np
from numba import carray

from flatplank_analysis.contact_patch.compiling import (
    choose,
    entry,
    exponential,
    inline,
    inner,
    pointer,
)
from flatplank_analysis.contact_patch.laws import (
    fallen,
    free_law,
    patch_length,
    play_position,
    shared,
    slip_of,
    slipping,
    softened,
    steady,
)

#: columns of the parameter block, one row per parameter set and run
NAMES = (
    "stiff", "peak", "shape", "fall", "round", "denom", "carcass", "half", "tread",
    "asym_peak", "asym_stiff", "play", "play_at", "play_soft", "give", "soften",
    "creep", "creep_time", "slide", "follow", "other_slip", "loss_brake", "loss_drive",
    "play_rest", "play_hold", "patch_order", "turn", "load_share", "turn_share", "turn_rate",
    "start", "fixed_length",
    "law_0", "law_1", "law_2", "law_3",
)  # fmt: skip
(
    STIFF, PEAK, SHAPE, FALL, ROUND, DENOM, CARCASS, HALF, TREAD,
    ASYM_PEAK, ASYM_STIFF, PLAY, PLAY_AT, PLAY_SOFT, GIVE, SOFTEN,
    CREEP, CREEP_TIME, SLIDE, FOLLOW, OTHER_SLIP, LOSS_BRAKE, LOSS_DRIVE,
    PLAY_REST, PLAY_HOLD, PATCH_ORDER, TURN, LOAD_SHARE, TURN_SHARE, TURN_RATE,
    START, FIXED_LENGTH, LAW,
) = range(33)  # fmt: skip
WIDTH = len(NAMES)
#: further rows of a block: constants, state, inputs of a node, work space of a node
(
    FLEX, BEND, THETA_SHARE, NOMINAL, OTHER_STIFF, OTHER_PEAK, OTHER_LOAD_SHARE,
    OTHER_ASYM_PEAK, OTHER_ASYM_STIFF, OTHER_SLIDE,
    SLIP, FORCE, DEFLECTED, CREPT, SLOPE, RATE, PLACE,
    DS, DW, DT, LOAD, FRICTION, ACROSS,
    AT, SIGMA, LATE, THETA, LENGTH, BEYOND, STIFF_NOW, PEAK_NOW, SPEED_RATIO, STIFF_ACROSS,
    PEAK_ACROSS, AIM, WAY, NEW_FORCE, NEW_DEFLECTED, NEW_SLOPE, PATCH, LAST, MOVE, LOW, HIGH,
    NEW_PLACE, PLANK,
) = range(WIDTH, WIDTH + 46)  # fmt: skip
ROWS = PLANK + 1
WIDE = 8
"""elements of a block: one register of a processor with 512 bits, two of 256 bits"""
NEWTON, CLOSE = 60, 1e-6
"""most Newton steps, and the change of slip below which they end; the rest is linear"""
FAR = 1.0e3
"""upper bound of the slip in the Newton iteration"""


@inner
def set_up(flat, params, other, nominal, elements):
    """Constants of a block, and its state at standstill with the initial force.

    flat (ROWS * WIDE,); params and other (elements of all blocks, WIDTH): parameters in this
    direction and in the other; elements (WIDE,): indices of the elements of the block.
    """
    w = table(flat)
    w[:, :] = 0.0
    for i in range(WIDE):
        e = elements[i]
        p, o = params[e], other[e]
        for row in range(WIDTH):
            w[row, i] = p[row]
        w[FLEX, i] = 1.0 / p[CARCASS]
        # `round` removes the term of second order: 1 starts like a sine, 0 like a brush
        w[BEND, i] = p[ROUND] * (p[SHAPE] - 1.0) / (2.0 * p[SHAPE])
        # (7.19) with the tread stiffness tied to the slip stiffness
        w[THETA_SHARE, i] = p[TREAD] * p[STIFF] / (3.0 * p[PEAK] * nominal[e])
        w[NOMINAL, i] = nominal[e]
        w[OTHER_STIFF, i], w[OTHER_PEAK, i] = o[STIFF], o[PEAK]
        w[OTHER_LOAD_SHARE, i], w[OTHER_SLIDE, i] = o[LOAD_SHARE], o[SLIDE]
        w[OTHER_ASYM_STIFF, i], w[OTHER_ASYM_PEAK, i] = o[ASYM_STIFF], o[ASYM_PEAK]
        peak = p[PEAK] * nominal[e]
        slip, slope, force = slip_of(p[START], p[STIFF], peak, p[SHAPE], p[FALL], w[BEND, i])
        w[SLIP, i], w[FORCE, i] = slip, force
        w[SLOPE, i] = choose(force == 0.0, 0.0, slope)
        # the plank rests somewhere in its play: where friction holds it, or displaced by `start`
        # from the position that the force determines
        start = 0.5 * p[PLAY] * p[PLAY_REST]
        held = p[PLAY_HOLD]
        rest, _ = play_position(force, p[PLAY], p[PLAY_AT], p[PLAY_SOFT], held, start)
        w[PLACE, i] = rest
        soft = softened(force, p[SOFTEN])
        bent = force * soft + p[FIXED_LENGTH] * (p[STIFF] * slip - force)
        w[DEFLECTED, i] = choose(held > 0.0, rest, rest + start) + bent * w[FLEX, i]


@inline
def table(flat):
    """A block as a table whose width is a compile-time constant."""
    return carray(pointer(flat.ctypes.data), (ROWS, WIDE), np.float64)


@inner
def begin(flat, across):
    """Quantities of a node that do not depend on its slip, and a first guess of the slip."""
    w = table(flat)
    for i in range(WIDE):
        f0, x_soft, nominal = w[FORCE, i], max(w[SLOPE, i], 0.0) * w[FLEX, i], w[NOMINAL, i]
        loss = w[LOSS_BRAKE, i] * min(f0, 0.0) + w[LOSS_DRIVE, i] * max(f0, 0.0)
        ratio = w[LOAD, i] / nominal * (1.0 + loss / nominal)
        friction, way = w[FRICTION, i], w[DS, i]
        pulled = w[GIVE, i] * f0 + w[FOLLOW, i] * f0 / math.sqrt(f0 * f0 + 900.0)
        dw = w[DW, i] - pulled * way
        aim = w[CREEP, i] * f0 * w[FLEX, i]
        crept = aim + (w[CREPT, i] - aim) * exponential(-w[DT, i] / w[CREEP_TIME, i])
        dw = dw - (crept - w[CREPT, i])
        w[CREPT, i] = crept
        ds = max(way + w[DENOM, i] * dw, 0.0)
        theta = w[THETA_SHARE, i] / friction
        half = w[HALF, i] * (1.0 + 0.6 * (ratio - 1.0))
        k0 = w[SLIP, i]
        whole = abs(k0)
        if across is not None:
            slip_across = w[ACROSS, i]
            stiff_across = w[OTHER_STIFF, i] * (1.0 + w[OTHER_LOAD_SHARE, i] * (ratio - 1.0))
            peak_across = w[OTHER_PEAK, i] * friction * ratio * nominal
            back = choose(slip_across < 0.0, 1.0, 0.0)
            stiff_across = stiff_across * (1.0 - back * w[OTHER_ASYM_STIFF, i])
            peak_across = peak_across * (1.0 - back * w[OTHER_ASYM_PEAK, i])
            peak_across = slipping(slip_across, peak_across, w[OTHER_SLIDE, i], w[SPEED_RATIO, i])
            scale = w[OTHER_STIFF, i] * w[PEAK, i] / (w[STIFF, i] * w[OTHER_PEAK, i])
            beyond = (scale * slip_across) ** 2
            whole = math.sqrt(k0 * k0 + beyond)
            w[STIFF_ACROSS, i], w[PEAK_ACROSS, i] = stiff_across, peak_across
            w[BEYOND, i] = beyond
        sigma = patch_length(k0, whole, theta, half, w[PLANK, i]) + fallen(w[SLOPE, i], w[FLEX, i])
        late = max(0.5, 1.0 - (sigma + x_soft) / ds)
        # first guess: law and patch continue as at the last node
        t = 2.0 * sigma
        under = w[PATCH_ORDER, i] / 6.0 * t + late * ds
        rise = w[PATCH_ORDER, i] / 12.0 * t * t + 0.5 * late * ds * t
        patch = (late * ds * ds * k0 - ds * t * w[RATE, i]) / under
        stiff = (rise + late * late * ds * ds) / under
        w[AT, i] = k0 + (dw - patch) / (stiff + x_soft)
        w[AIM, i] = dw
        w[WAY, i] = ds
        w[SIGMA, i], w[LATE, i], w[THETA, i], w[LENGTH, i] = sigma, late, theta, half
        w[STIFF_NOW, i] = w[STIFF, i] * (1.0 + w[LOAD_SHARE, i] * (ratio - 1.0))
        w[PEAK_NOW, i] = w[PEAK, i] * friction * ratio * nominal
        w[LOW, i], w[HIGH, i], w[MOVE, i] = -FAR, FAR, 1.0


@inner
def newton(flat, across):
    """One safeguarded Newton step for the slip of each unconverged element; returns the largest
    move. The left-hand side increases with the slip unless the law falls steeply.
    """
    w = table(flat)
    for i in range(WIDE):
        k, k0, ds, late = w[AT, i], w[SLIP, i], w[WAY, i], w[LATE, i]
        whole = abs(k)
        if across is not None:
            whole = math.sqrt(k * k + w[BEYOND, i])
        back = choose(k < 0.0, 1.0, 0.0)
        stiff = w[STIFF_NOW, i] * (1.0 - back * w[ASYM_STIFF, i])
        peak = w[PEAK_NOW, i] * (1.0 - back * w[ASYM_PEAK, i])
        shape, fall, bend = w[SHAPE, i], w[FALL, i], w[BEND, i]
        peak = slipping(k, peak, w[SLIDE, i], w[SPEED_RATIO, i])
        force, slope = steady(k, stiff, peak, shape, fall, bend)
        if across is not None:
            way_y = w[ACROSS, i] / w[PEAK_ACROSS, i]
            bent_y = w[STIFF_ACROSS, i] * way_y
            turn = w[TURN_SHARE, i], w[TURN_RATE, i]
            both = shared(k, stiff, peak, bent_y, way_y, shape, fall, bend, *turn)
            near = shared(k + 1e-6, stiff, peak, bent_y, way_y, shape, fall, bend, *turn)
            turned = (near - both) * 1e6
            alone = w[ACROSS, i] == 0.0
            force = choose(alone, force, both)
            slope = choose(alone, slope, turned)
        heights = w[LAW, i], w[LAW + 1, i], w[LAW + 2, i], w[LAW + 3, i]
        change, bent = free_law(k, *heights)
        slope = slope * change + force * bent
        force = force * change
        soft = softened(force, w[SOFTEN, i])
        straight = w[FIXED_LENGTH, i] * w[FLEX, i]
        deflected = force * soft * w[FLEX, i] + straight * (stiff * k - force)
        flex, spare = (2.0 * soft - 1.0) * w[FLEX, i], straight * (stiff - slope)
        length = patch_length(k, whole, w[THETA, i], w[LENGTH, i], w[PLANK, i])
        t = w[SIGMA, i] + length + fallen(slope, flex)
        under = 1.0 / (w[PATCH_ORDER, i] / 6.0 * t + late * ds)
        rise = w[PATCH_ORDER, i] / 12.0 * t * t + 0.5 * late * ds * t
        ahead = late * ds * ds * (late * k + (1.0 - late) * k0)
        patch = (rise * (k - k0) - ds * t * w[RATE, i] + ahead) * under
        play, at, yields, held = w[PLAY, i], w[PLAY_AT, i], w[PLAY_SOFT, i], w[PLAY_HOLD, i]
        place, rate = play_position(force, play, at, yields, held, w[PLACE, i])
        deflected, flex = deflected + place, flex + rate
        miss = patch + deflected - w[DEFLECTED, i] - w[AIM, i]
        rigid = (rise + late * late * ds * ds) * under
        trial = k - miss / (rigid + max(slope, 0.0) * flex + spare)
        low, high, before = w[LOW, i], w[HIGH, i], w[MOVE, i]
        high = choose(miss > 0.0, k, high)
        low = choose(miss > 0.0, low, k)
        # bisect only between two known bounds; a residual of exactly zero is no reason for it
        halve = choose(trial < low, 1.0, 0.0)
        halve = choose(trial > high, 1.0, halve)
        halve = choose(low > -FAR, halve, 0.0)
        halve = choose(high < FAR, halve, 0.0)
        middle = 0.5 * (low + high)
        trial = choose(halve > 0.0, middle, trial)
        move = trial - k
        # a converged element does not change
        going = abs(before) >= CLOSE
        # the last step is so small that everything else is linear
        new_force, new_deflected = force + slope * move, deflected + (slope * flex + spare) * move
        new_patch = patch + rigid * move
        new_place = place + slope * rate * move
        old_force, old_deflected = w[NEW_FORCE, i], w[NEW_DEFLECTED, i]
        old_patch, old_slope, old_t = w[PATCH, i], w[NEW_SLOPE, i], w[LAST, i]
        w[LOW, i], w[HIGH, i] = low, high
        w[AT, i] = choose(going, trial, k)
        w[MOVE, i] = choose(going, move, before)
        w[NEW_FORCE, i] = choose(going, new_force, old_force)
        w[NEW_DEFLECTED, i] = choose(going, new_deflected, old_deflected)
        w[NEW_PLACE, i] = choose(going, new_place, w[NEW_PLACE, i])
        w[NEW_SLOPE, i] = choose(going, slope, old_slope)
        w[PATCH, i] = choose(going, new_patch, old_patch)
        w[LAST, i] = choose(going, t, old_t)
    largest = 0.0
    for i in range(WIDE):
        largest = max(largest, abs(w[MOVE, i]))
    return largest


@inner
def end(flat):
    """Store the results of a node as the new state."""
    w = table(flat)
    for i in range(WIDE):
        k, k0, late, ds = w[AT, i], w[SLIP, i], w[LATE, i], w[WAY, i]
        over = w[PATCH, i] - ds * (late * k + (1.0 - late) * k0)
        w[RATE, i] = w[RATE, i] - 0.5 * (k - k0) + over / w[LAST, i]
        w[SLIP, i] = k
        w[FORCE, i], w[DEFLECTED, i] = w[NEW_FORCE, i], w[NEW_DEFLECTED, i]
        w[SLOPE, i], w[PLACE, i] = w[NEW_SLOPE, i], w[NEW_PLACE, i]


@inner
def node(flat, across):
    """Solve one node of a block whose inputs are set."""
    begin(flat, across)
    for _ in range(NEWTON):
        if newton(flat, across) < CLOSE:
            break
    end(flat)


@inner
def inputs(flat, n, axis, elements, ds, dw, dt, load, friction, speed):
    """Put the inputs of a node into a block; arrays (elements, samples), dw (2, e, s)."""
    w = table(flat)
    for i in range(WIDE):
        e = elements[i]
        w[DS, i], w[DW, i], w[DT, i] = ds[e, n], dw[axis, e, n], dt[e, n]
        w[LOAD, i], w[FRICTION, i] = load[e, n], friction[e, n]
        w[PLANK, i] = choose(axis == 0, 1.0 - w[DENOM, i], 0.0)
    for i in range(WIDE):
        ratio = abs(w[DS, i]) / w[DT, i] / speed
        w[SPEED_RATIO, i] = choose(w[DT, i] > 0.0, ratio, 0.0)


@inner
def add_other_slip(flat, other):
    """Put the slip in the other direction into a block, weighted by their shared friction."""
    w, o = table(flat), table(other)
    for i in range(WIDE):
        w[ACROSS, i] = w[OTHER_SLIP, i] * o[SLIP, i]


@inner
def through(flat, along, n, elements, dw):
    """Add the travel of the rubber with the wheel through the contact, for both directions."""
    w, x = table(flat), table(along)
    for i in range(WIDE):
        slip = dw[0, elements[i], n] - x[GIVE, i] * x[FORCE, i] * w[DS, i]
        w[DS, i] = w[DS, i] + w[TURN, i] * slip


@inner
def both_nodes(x, y, n, do_x, do_y, elements, ds, dw, dt, load, friction, speed, across):
    """Solve one node of a block along (x) and across (y) the wheel plane, or in one direction."""
    if do_y:
        inputs(y, n, 1, elements, ds, dw, dt, load, friction, speed)
        through(y, x, n, elements, dw)
    if do_x:
        inputs(x, n, 0, elements, ds, dw, dt, load, friction, speed)
        add_other_slip(x, y)
        node(x, across)
    if do_y:
        add_other_slip(y, x)
        node(y, across)


@entry
def sweep(blocks, do_x, do_y, ds, dw, dt, load, friction, params, nominal, speed, force, across):
    """Solve all nodes of some blocks.

    blocks (blocks, WIDE): see `blocks_of`; do_x, do_y: the directions to solve; ds, dt,
    load, friction (elements, samples), dw and force (2, elements, samples), params (2, elements,
    WIDTH). across is None where no element has lateral slip, which halves the cost.
    """
    x, y = np.empty(ROWS * WIDE), np.empty(ROWS * WIDE)
    for b in range(blocks.shape[0]):
        elements = blocks[b]
        set_up(x, params[0], params[1], nominal, elements)
        set_up(y, params[1], params[0], nominal, elements)
        for n in range(ds.shape[1]):
            both_nodes(x, y, n, do_x, do_y, elements, ds, dw, dt, load, friction, speed, across)
            for i in range(WIDE):
                if do_x:
                    force[0, elements[i], n] = x[FORCE * WIDE + i]
                if do_y:
                    force[1, elements[i], n] = y[FORCE * WIDE + i]


@entry
def one_node(states, blocks, ds, dw, dt, load, friction, speed, force, across):
    """Solve one node of all blocks in both directions; states (2, blocks, ROWS * WIDE), from
    `rest`; ds, dt, load, friction (elements, 1), dw and force (2, elements, 1)."""
    for b in range(blocks.shape[0]):
        x, y, elements = states[0, b], states[1, b], blocks[b]
        both_nodes(x, y, 0, True, True, elements, ds, dw, dt, load, friction, speed, across)
        for i in range(WIDE):
            force[0, elements[i], 0] = x[FORCE * WIDE + i]
            force[1, elements[i], 0] = y[FORCE * WIDE + i]


@entry
def rest(blocks, params, nominal):
    """State at standstill without force (2, blocks, ROWS * WIDE)."""
    states = np.empty((2, blocks.shape[0], ROWS * WIDE))
    for b in range(blocks.shape[0]):
        for axis in range(2):
            set_up(states[axis, b], params[axis], params[1 - axis], nominal, blocks[b])
    return states


def blocks_of(elements: np.ndarray) -> np.ndarray:
    """Elements in blocks (blocks, WIDE); the last one is repeated where some are missing."""
    missing = -len(elements) % WIDE
    return np.concatenate([elements, elements[-1:].repeat(missing)]).reshape(-1, WIDE)
