# SPDX-License-Identifier: Apache-2.0
"""Appendix A of the thesis: bridge volts to forces at the wheel centre (A.1), at the contact point
(A.2), and back.

(A.1) gives five of six components; the moment about the spin axis is not measured and set to zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from flatplank_hw.bus.image import BusInputs
from flatplank_hw.cia402 import TORQUE_UNIT
from flatplank_hw.hub.params import DRIVE_MOMENTS, HubParameters
from flatplank_hw.samples import Wrench

OUTER_ARM = 0.3475
"""arm of the bridges Fx1 and Fz1 in (A.1d, A.1e), without ET value and adapter [m]"""
INNER_ARM = 0.0475
"""arm of the bridges Fx2 and Fz2, without ET value and adapter [m]"""

Volts = tuple[float, float, float, float, float, float]


class Gains(NamedTuple):
    """Newtons per volt of each channel and the two arms [m]."""

    c1: float
    c2: float
    c3: float
    c5: float
    c6: float
    outer: float
    inner: float


def gains(p: HubParameters) -> Gains:
    """Compute the gains of (A.1), g 4e5 / (A k), and the arms."""
    base = p.gravity * 4e5
    shift = p.adapter_thickness - p.et_value
    return Gains(
        c1=base / (p.a_fy * p.k_fy),
        c2=base / (p.a_fx * p.k_fx1),
        c3=base / (p.a_fx * p.k_fx2),
        c5=base / (p.a_fz * p.k_fz2),
        c6=base / (p.a_fz * p.k_fz1),
        outer=OUTER_ARM + shift,
        inner=INNER_ARM + shift,
    )


def wheel_from_volts(volts: Volts, g: Gains, my: float = 0.0) -> Wrench:
    """Compute the wrench at the wheel centre from C1..C6 [V] by (A.1); C4 is not used."""
    c1, c2, c3, _, c5, c6 = volts
    x1, x2, z1, z2 = g.c2 * c2, g.c3 * c3, g.c6 * c6, g.c5 * c5
    return Wrench(
        -(x1 + x2),
        g.c1 * c1,
        z1 + z2,
        z2 * g.inner + z1 * g.outer,
        my,
        x1 * g.outer + x2 * g.inner,
    )


def contact_from_wheel(wheel: Wrench, loaded_radius: float, cos: float, sin: float) -> Wrench:
    """Compute the wrench at the contact point by (A.2).

    cos, sin: of the total camber. M_yc of the wrench, zero in the thesis, acts in M_yw and M_zw.
    """
    fx, fy, fz, mx, my, mz = wheel
    spin = loaded_radius * fx + my
    return Wrench(
        fx,
        cos * fy - sin * fz,
        sin * fy + cos * fz,
        mx - loaded_radius * fy,
        cos * spin - sin * mz,
        sin * spin + cos * mz,
    )


def force_balance(inputs: BusInputs, fx: float, loaded_radius: float, p: HubParameters) -> float:
    """Estimate M_yc = -r_l Fx [N m]: the drive moment balances Fx, no rolling resistance."""
    return -loaded_radius * fx


def motor_torque(inputs: BusInputs, fx: float, loaded_radius: float, p: HubParameters) -> float:
    """Estimate M_yc = -eta i (M_M - M_F) [N m] by (5.3), 0 when braking: the gear is self-locking,
    so the motor does not carry a braking moment."""
    axis = inputs.axes[0]
    speed = abs(axis.velocity) * 2.0 * math.pi / abs(p.motor_counts_per_turn)
    friction = float(np.interp(speed, p.friction_speed, p.friction_torque))
    return -p.efficiency * p.gear_ratio * max(axis.torque * TORQUE_UNIT - friction, 0.0)


Source = Callable[[BusInputs, float, float, HubParameters], float]
SOURCES: dict[str, Source] = dict(zip(DRIVE_MOMENTS, (force_balance, motor_torque), strict=True))
