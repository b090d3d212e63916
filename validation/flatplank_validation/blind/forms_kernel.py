# SPDX-License-Identifier: Apache-2.0
"""A machine with unusual forms of faults, with the tire of cells of the second kit.

Each fault follows its physics. A clearance has Hertz contact at its stops, an oil film in between,
and dry friction. Oil drags a gear across its gap. Wear, grip and crosstalk saturate, drifts have a
time constant. A slide unloads with hysteresis, rubber creeps with two time constants. Masses are
neglected.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from flatplank_validation.blind.second_kernel import (
    ALPHA,
    CAMBER_SLIP,
    CARCASS_X,
    CELLS,
    NOMINAL,
    RADIUS,
    SAMPLE,
    START,
    SUB,
    driven,
    tire_step,
)

#: parameters of the machine, in the order in which the kernel gets them
FORMS = (
    "road_gap", "side_gap", "sink_gap", "drive_gap", "rack_gap",
    "ripple", "ripple_period", "ripple_phase", "droop",
    "loss", "out_1", "out_2", "wave", "wave_period", "wave_phase",
    "brake_grip", "softening", "creep",
)  # fmt: skip
FORM_AT = {name: i for i, name in enumerate(FORMS)}
(
    ROAD_GAP, SIDE_GAP, SINK_GAP, DRIVE_GAP, RACK_GAP,
    RIPPLE, RIPPLE_PERIOD, RIPPLE_PHASE, DROOP,
    LOSS, OUT_1, OUT_2, WAVE, WAVE_PERIOD, WAVE_PHASE,
    BRAKE_GRIP, SOFTENING, CREEP,
) = range(18)  # fmt: skip

FILM = 4.0e5
"""damping of the oil film in a clearance [N s/m]"""
HOLD = 15.0
"""dry friction without force [N]; HOLD_SHARE adds a part of the force"""
HOLD_SHARE = 0.01
HERTZ = 2.0e10
"""Hertz stiffness of a stop [N/m^1.5]: 3 kN deflect it by 0.03 mm"""
OIL = 0.12
"""part of a gear's motion that its oil transmits across the gap [-]"""
FLANK_TIME = 0.15
"""time for one flank to settle on the other [s]"""
GUIDE = 35.0
"""friction of the guides, which holds the plank on one flank of its rack [N]"""
VERTICAL = 1.06e5
"""vertical stiffness of the tire [N/m]"""


@njit(cache=True, nogil=True)
def pressed(force):
    """Deflection of a stop under a force [m]."""
    return (abs(force) / HERTZ) ** (2.0 / 3.0)


@njit(cache=True, nogil=True)
def in_clearance(at, gap, force, h):
    """Position of a part with friction and an oil film in a clearance, after a time step `h`."""
    hold = HOLD + HOLD_SHARE * abs(force)
    push = 0.0
    if abs(force) > hold:
        push = force - math.copysign(hold, force)
    limit = 0.5 * gap + pressed(force)
    new = at + push / FILM * h
    if push == 0.0:
        return min(max(at, -limit), limit)
    # near the stop the film is squeezed out and slows the part down
    room = limit - math.copysign(1.0, push) * at
    slow = room / (room + 0.1 * gap + 1e-9) if room > 0.0 else 0.0
    new = at + push / FILM * h * slow
    return min(max(new, -limit), limit)


@njit(cache=True, nogil=True)
def triangle(u):
    """A rounded triangle wave over u [turns]; its first harmonic is 1."""
    return math.asin(0.96 * math.sin(2.0 * math.pi * u)) / 1.16104


@njit(cache=True, nogil=True)
def lobed(angle, order):
    """A wave with sharp peaks and flat troughs; its first harmonic is 1."""
    return math.cos(order * angle) + 0.25 * math.cos(2.0 * order * angle)


@njit(cache=True, nogil=True)
def run_forms(p, q, friction, bumps, out):
    """Simulate one run from standstill; out: shape (6, samples); returns the number of samples."""
    h = SAMPLE / SUB
    bend, trial = np.zeros((2, CELLS)), np.zeros((2, CELLS))
    carcass = np.zeros(5)
    own = p.copy()
    pinion = wheel = speed = last_ripple = 0.0
    plate = side_at = sunk = slide = late = 0.0
    # rolling resistance leaves the gear closer to its braking flank
    flank = -0.3 * q[DRIVE_GAP]
    rack = -0.5 * q[RACK_GAP]
    short = long = 0.0
    total = out.shape[1] * SUB
    for n in range(total):
        t = n * h
        fx, fy = carcass[3], carcass[4]
        speed, travel, free, turned = driven(p, t, h, pinion, speed, fx)
        pinion += travel
        wheel += turned
        angle = wheel / p[RADIUS] + p[START]
        # belt or gear of the road: pitch error, and delayed elasticity
        wave = q[RIPPLE] * triangle(pinion / q[RIPPLE_PERIOD] + q[RIPPLE_PHASE])
        late += (fx - late) * h / 1.5
        road = travel * (1.0 + q[DROOP] * late) + wave - last_ripple
        last_ripple = wave
        # gear of the wheel: in the gap only the oil drags the follower
        before = flank
        limit = q[DRIVE_GAP] + pressed(fx)
        moved = (1.0 - OIL) * (turned - free)
        room = max(limit - math.copysign(1.0, moved) * flank, 0.0)
        flank += moved * room / (room + 0.15 * q[DRIVE_GAP] + 1e-9)
        flank = min(max(flank, -limit), limit)
        lost = flank - before
        # rack of the plank: it stays on one flank until the tire force exceeds the guide friction
        before = rack
        aim = 0.5 * q[RACK_GAP] if fx > GUIDE else -0.5 * q[RACK_GAP]
        if abs(fx - GUIDE) > 0.3 * GUIDE:
            rack += (aim - rack) * h / (FLANK_TIME + 100.0 / (abs(fx - GUIDE) + 50.0))
        road += rack - before
        # load: one part that the hub measures, and one that it does not
        load = p[NOMINAL] + bumps[0] * math.sin(pinion / 0.207 + bumps[1])
        load += bumps[2] * math.cos(pinion / 0.0796 + bumps[3])
        radial = q[OUT_1] * lobed(angle - 0.7, 1.0) + q[OUT_2] * lobed(angle - 0.2, 2.0)
        load += VERTICAL * radial * (1.0 + radial / 0.02)
        brake = min(fx, 0.0)
        # the slide sticks up to 150 N before it unloads; its lever grows
        slide = min(max(slide, brake - 150.0), brake + 150.0)
        lever = (1.0 - min(slide, 0.0) / 2000.0) / 2.0
        load *= 1.0 + q[LOSS] * lever * min(slide, 0.0) / p[NOMINAL]
        sunk += (q[SINK_GAP] * 2.0 / math.pi * math.atan(fx / 300.0) - sunk) * h / 0.4
        load += VERTICAL * sunk
        crest = 1.0 + 0.15 * math.sin(pinion / 0.9)
        unseen = q[WAVE] * load * crest * triangle(pinion / q[WAVE_PERIOD] + q[WAVE_PHASE])
        rolled = (turned - lost) * (1.0 + radial / p[RADIUS])
        before = plate
        plate = in_clearance(plate, q[ROAD_GAP], fx, h)
        slip = rolled - road - (plate - before)
        before = side_at
        side_at = in_clearance(side_at, q[SIDE_GAP], fy, h)
        side = (p[CAMBER_SLIP] - math.tan(p[ALPHA])) * road - (side_at - before)
        k = min(int(max(pinion, 0.0) * 500.0), friction.shape[0] - 1)
        grip = friction[k] * (1.0 - q[BRAKE_GRIP] * (1.0 - math.exp(brake / 1200.0)))
        # the carcass softens towards a limit, and creeps with two time constants
        own[CARCASS_X] = p[CARCASS_X] / (1.0 + q[SOFTENING] * (1.0 - math.exp(-abs(fx) / 2500.0)))
        short += (0.6 * q[CREEP] * fx / p[CARCASS_X] - short) * h / 3.0
        long += (0.4 * q[CREEP] * fx / p[CARCASS_X] - long) * h / 20.0
        carcass[2] = short + long
        tire_step(own, bend, carcass, rolled, slip, side, load + unseen, grip, h, trial)
        if n % SUB == SUB - 1:
            i = n // SUB
            out[0, i], out[1, i] = pinion, wheel / p[RADIUS]
            out[2, i], out[3, i] = carcass[3], carcass[4]
            out[4, i], out[5, i] = load + unseen, load
            if pinion > 4.15:
                return i + 1
    return out.shape[1]
