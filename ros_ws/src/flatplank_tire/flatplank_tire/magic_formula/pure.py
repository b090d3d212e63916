# SPDX-License-Identifier: Apache-2.0
"""Pure slip: Fx0 and Fy0 of the Magic Formula (equations 4.E9 to 4.E30).

Terms of 5.2 that differ are marked (Pacejka 2006, section 4.3.2; the same terms in PAC2002):
camber has a scaling factor of its own in Fx, Fy and Mz, and shifts the side slip by PHY3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flatplank_tire.magic_formula import turn_slip
from flatplank_tire.magic_formula.coefficients import LATEST, Coefficients
from flatplank_tire.magic_formula.state import (
    OperatingPoint,
    Value,
    away_from_zero,
    capped,
    curve_angle,
    digressive,
    sign,
    slip_angle,
)
from flatplank_tire.magic_formula.turn_slip import Spin


class PureX(NamedTuple):
    """Fx0 [N] and slip stiffness K_xk [N] (dFx/dkappa at the inflection)."""

    fx0: Value
    kxk: Value


class PureY(NamedTuple):
    """Fy0 [N], K_ya [N/rad], and inputs of the moment: mu_y, S_Hy [rad], S_Vy [N], B_y, C_y."""

    fy0: Value
    kya: Value
    mu_y: Value
    sh_y: Value
    sv_y: Value
    b_y: Value
    c_y: Value


def longitudinal_stiffness(c: Coefficients, o: OperatingPoint) -> Value:
    """Longitudinal slip stiffness K_xk (4.E15) [N]."""
    pressure = 1.0 + c.PPX1 * o.dpi + c.PPX2 * o.dpi * o.dpi
    return o.fz * (c.PKX1 + c.PKX2 * o.dfz) * np.exp(c.PKX3 * o.dfz) * pressure * c.LKX


def longitudinal(c: Coefficients, o: OperatingPoint, spin: Spin | None = None) -> PureX:
    """Fx at zero slip angle (4.E9 to 4.E18)."""
    pressure = 1.0 + c.PPX3 * o.dpi + c.PPX4 * o.dpi * o.dpi
    gamma = o.gamma * c.LGAX
    camber = 1.0 - c.PDX3 * gamma * gamma
    turned = 1.0 if spin is None else turn_slip.zeta_1(c, o, spin)
    d_x = (c.PDX1 + c.PDX2 * o.dfz) * pressure * camber * c.LMUX * o.fz * turned
    c_x = c.PCX1 * c.LCX
    kxk = longitudinal_stiffness(c, o)
    b_x = kxk / away_from_zero(c_x * d_x)
    kappa_x = o.kappa + (c.PHX1 + c.PHX2 * o.dfz) * c.LHX
    e_x = (c.PEX1 + (c.PEX2 + c.PEX3 * o.dfz) * o.dfz) * (1.0 - c.PEX4 * sign(kappa_x)) * c.LEX
    e_x = capped(c, e_x)
    sv_x = o.fz * (c.PVX1 + c.PVX2 * o.dfz) * c.LVX * digressive(c, c.LMUX) * turned
    return PureX(d_x * np.sin(curve_angle(c_x, b_x, e_x, kappa_x)) + sv_x, kxk)


def cornering_stiffness(c: Coefficients, o: OperatingPoint) -> Value:
    """Cornering stiffness K_ya (4.E25) [N/rad]; arctan2 also covers PKY2 = 0."""
    gamma = o.gamma * c.LGAY
    load_of_maximum = (c.PKY2 + c.PKY5 * gamma * gamma) * (1.0 + c.PPY2 * o.dpi)
    fz0 = c.LFZO * c.FNOMIN
    angle = np.arctan2(o.fz / fz0 * sign(load_of_maximum), np.abs(load_of_maximum))
    factor = c.PKY1 * fz0 * (1.0 + c.PPY1 * o.dpi) * (1.0 - c.PKY3 * np.abs(gamma))
    return factor * np.sin(c.PKY4 * angle) * c.LKY


def lateral(c: Coefficients, o: OperatingPoint, spin: Spin | None = None) -> PureY:
    """Fy at zero longitudinal slip (4.E19 to 4.E30)."""
    kya, peak = cornering_stiffness(c, o), 1.0
    if spin is not None:
        kya, peak = kya * turn_slip.zeta_3(c, o, spin), turn_slip.zeta_2(c, o, spin)
    o, shifts = o._replace(gamma=o.gamma * c.LGAY), digressive(c, c.LMUY) * peak
    sv_gamma = o.fz * (c.PVY3 + c.PVY4 * o.dfz) * o.gamma * c.LKYC * shifts
    sh_y = (c.PHY1 + c.PHY2 * o.dfz) * c.LHY
    if spin is not None:
        upright = cornering_stiffness(c, o._replace(gamma=0.0))
        upright = upright * turn_slip.zeta_3(c, o, spin)
        share = sv_gamma / away_from_zero(kya)
        sh_y = sh_y + turn_slip.shift_y(c, o, spin, camber_stiffness(c, o), upright, share)
    elif c.law != LATEST:
        sh_y = sh_y + c.PHY3 * o.gamma
    else:  # the shift that gives the camber stiffness K_yg0 (4.E27, 4.E30)
        sh_y = sh_y + (camber_stiffness(c, o) * o.gamma - sv_gamma) / away_from_zero(kya)
    sv_y = o.fz * (c.PVY1 + c.PVY2 * o.dfz) * c.LVY * shifts + sv_gamma
    return _lateral_curve(c, o, kya, sh_y, sv_y, peak)


def camber_stiffness(c: Coefficients, o: OperatingPoint) -> Value:
    """Camber stiffness K_yg0 (4.E30) [N/rad]."""
    return o.fz * (c.PKY6 + c.PKY7 * o.dfz) * (1.0 + c.PPY5 * o.dpi) * c.LKYC


def _lateral_curve(
    c: Coefficients, o: OperatingPoint, kya: Value, sh_y: Value, sv_y: Value, peak: Value
) -> PureY:
    alpha_y = slip_angle(c, o) + sh_y
    gamma2 = o.gamma * o.gamma
    pressure = 1.0 + c.PPY3 * o.dpi + c.PPY4 * o.dpi * o.dpi
    mu_y = (c.PDY1 + c.PDY2 * o.dfz) * pressure * (1.0 - c.PDY3 * gamma2) * c.LMUY
    d_y = mu_y * o.fz * peak
    c_y = c.PCY1 * c.LCY
    b_y = kya / away_from_zero(c_y * d_y)
    asymmetry = (c.PEY3 + c.PEY4 * o.gamma) * sign(alpha_y)
    e_y = (c.PEY1 + c.PEY2 * o.dfz) * (1.0 + c.PEY5 * gamma2 - asymmetry) * c.LEY
    e_y = capped(c, e_y)
    fy0 = d_y * np.sin(curve_angle(c_y, b_y, e_y, alpha_y)) + sv_y
    return PureY(fy0, kya, mu_y, sh_y, sv_y, b_y, c_y)
