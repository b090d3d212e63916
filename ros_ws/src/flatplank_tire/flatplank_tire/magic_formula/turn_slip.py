# SPDX-License-Identifier: Apache-2.0
"""Turn slip: the factors zeta by which the curvature of the path changes forces and moments.

Equations 4.75 to 4.106 of Pacejka (2012), section 4.3.3; an option, because they replace the
camber terms of 4.E27 and 4.E47 by the spin caused by camber. A path that turns to the left is
positive: it spins the contact like a camber to the right, and a small camber has the same side
force and moment with these equations and without. Differences between programs are described in
docs/reference/conventions.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flatplank_tire.magic_formula.coefficients import SECTIONS, Coefficients
from flatplank_tire.magic_formula.state import (
    OperatingPoint,
    Value,
    away_from_zero,
    cos_atan,
    curve_angle,
    sign,
)

COEFFICIENTS = tuple(SECTIONS["TURNSLIP_COEFFICIENTS"].split())


class Spin(NamedTuple):
    """Path curvature phi_t and total spin phi [1/m], including camber; eps_gamma [-]."""

    phi_t: Value
    phi: Value
    eps: Value


def spin_of(c: Coefficients, o: OperatingPoint, phi_t: Value, radius: Value) -> Spin:
    """Spin at a path curvature phi_t [1/m], positive to the left, and an effective rolling radius
    [m] (4.75, 4.76, 4.90)."""
    eps = c.PECP1 * (1.0 + c.PECP2 * o.dfz)
    if not np.any(o.gamma):
        return Spin(phi_t, phi_t, eps)
    # omega / V_c: also at rest
    turns = (1.0 + o.kappa) * np.cos(o.alpha) / radius
    return Spin(phi_t, phi_t + (1.0 - eps) * turns * np.sin(o.gamma), eps)


def zeta_1(c: Coefficients, o: OperatingPoint, s: Spin) -> Value:
    """zeta_1: factor of the peak of Fx (4.105, 4.106)."""
    b = c.PDXP1 * (1.0 + c.PDXP2 * o.dfz) * cos_atan(c.PDXP3 * o.kappa)
    return cos_atan(b * c.UNLOADED_RADIUS * s.phi)


def zeta_2(c: Coefficients, o: OperatingPoint, s: Spin) -> Value:
    """zeta_2: factor of the peak of Fy (4.77, 4.78)."""
    b = c.PDYP1 * (1.0 + c.PDYP2 * o.dfz) * cos_atan(c.PDYP3 * np.tan(o.alpha))
    turn = c.UNLOADED_RADIUS * np.abs(s.phi)
    return cos_atan(b * (turn + c.PDYP4 * np.sqrt(turn)))


def zeta_3(c: Coefficients, _o: OperatingPoint, s: Spin) -> Value:
    """zeta_3: factor of the cornering stiffness (4.79)."""
    return cos_atan(c.PKYP1 * (c.UNLOADED_RADIUS * s.phi) ** 2)


def shift_y(
    c: Coefficients, o: OperatingPoint, s: Spin, kyg0: Value, kya0: Value, sv_share: Value
) -> Value:
    """zeta_4 - 1 [rad]: shift of the side slip by spin (4.80 to 4.89).

    kyg0: camber stiffness; kya0: cornering stiffness without camber [N/rad]; sv_share: vertical
    shift of camber over the cornering stiffness [rad].
    """
    peak = (c.PHYP2 + c.PHYP3 * o.dfz) * sign(o.vx)
    b = _over(kyg0, (1.0 - s.eps) * c.PHYP1 * peak * away_from_zero(kya0))
    turn = c.UNLOADED_RADIUS * s.phi
    return peak * np.sin(curve_angle(c.PHYP1, b, c.PHYP4, turn)) * sign(o.vx) - sv_share


def zeta_5(c: Coefficients, _o: OperatingPoint, s: Spin) -> Value:
    """zeta_5: factor of the pneumatic trail (4.91)."""
    return cos_atan(c.QDTP1 * c.UNLOADED_RADIUS * s.phi)


def zeta_6(c: Coefficients, _o: OperatingPoint, s: Spin) -> Value:
    """zeta_6: factor of the slope of the residual moment (4.102)."""
    return cos_atan(c.QBRP1 * c.UNLOADED_RADIUS * s.phi)


def residual_moment(
    c: Coefficients, o: OperatingPoint, s: Spin, mu_y: Value, g_yk: Value
) -> tuple[Value, Value]:
    """zeta_7, shape [-], and zeta_8 - 1, size [Nm], of the residual moment (4.92 to 4.104)."""
    r0, fz0 = c.UNLOADED_RADIUS, c.LFZO * c.FNOMIN
    most = c.QCRP1 * np.abs(mu_y) * r0 * o.fz * np.sqrt(o.fz / fz0) * c.LMP
    peak = _over(most, np.sin(0.5 * np.pi * c.QDRP1))
    by_camber = c.QDZ8 + c.QDZ9 * o.dfz + (c.QDZ10 + c.QDZ11 * o.dfz) * np.abs(o.gamma)
    slope = o.fz * r0 * by_camber * c.LKZC
    b = _over(slope, c.QDRP1 * peak * (1.0 - s.eps))
    size = peak * np.sin(curve_angle(c.QDRP1, b, c.QDRP2, r0 * s.phi))
    across = most * (2.0 / np.pi) * np.arctan(c.QCRP2 * r0 * np.abs(s.phi_t)) * g_yk
    share = np.clip(across / away_from_zero(np.abs(size)), -1.0, 1.0)
    return 2.0 / np.pi * np.arccos(share), size


def _over(above: Value, below: Value) -> Value:
    """Quotient; 0 without load, where both are 0."""
    return np.where(below == 0.0, 0.0, above / np.where(below == 0.0, 1.0, below))
