# SPDX-License-Identifier: Apache-2.0
"""Moments: aligning Mz (4.E31 to 4.E49, 4.E71 to 4.E78), overturning Mx, rolling resistance My.

Where the book and the article of 2010 differ, the article is followed, as MF-Tyre does: the trail
grows with QDZ3 gamma (signed), its slope with QBZ4 gamma + QBZ5 |gamma|, the arm of Fx uses
FNOMIN, and the equivalent slip angles go through tangents (A54, A55). My (A48) is negative for a
wheel that rolls forward (ISO W); the book (4.E70) has it positive and with one more Fz.

In 5.2 the camber thrust has the trail of all side force, the camber of trail and residual moment
has the scaling factor LGAZ, Mx has three coefficients, My a share of the load (Pacejka 2006,
section 4.3.2).
"""

from __future__ import annotations

import numpy as np

from flatplank_tire.magic_formula import turn_slip
from flatplank_tire.magic_formula.coefficients import LATEST, Coefficients
from flatplank_tire.magic_formula.pure import PureY, lateral
from flatplank_tire.magic_formula.state import (
    OperatingPoint,
    Value,
    away_from_zero,
    capped,
    cos_atan,
    cos_course,
    curve_angle,
    nonzero,
    sign,
    slip_angle,
)
from flatplank_tire.magic_formula.turn_slip import Spin


def aligning(
    c: Coefficients,
    o: OperatingPoint,
    pure_y: PureY,
    kxk: Value,
    g_yk: Value,
    fx: Value,
    fy: Value,
    spin: Spin | None = None,
) -> Value:
    """Mz [Nm] at combined slip: trail times side force, residual moment, arm of Fx."""
    kya = away_from_zero(pure_y.kya)
    # (K_x/K_y kappa)^2: slip of the other direction, expressed as a slip angle
    other = kxk / kya * o.kappa
    other = other * other
    alpha, tilted = slip_angle(c, o), o._replace(gamma=o.gamma * c.LGAZ)
    alpha_r = _equivalent(c, alpha + pure_y.sh_y + pure_y.sv_y / kya, other)
    alpha_t = alpha + c.QHZ1 + c.QHZ2 * o.dfz + (c.QHZ3 + c.QHZ4 * o.dfz) * tilted.gamma
    fy_prime = _force_with_trail(c, o, pure_y, spin) * g_yk
    b_r = c.QBZ9 * c.LKY / nonzero(c.LMUY) + c.QBZ10 * pure_y.b_y * pure_y.c_y
    trail = _trail(c, tilted, alpha_t, _equivalent(c, alpha_t, other))
    if spin is None:
        moment = _residual(c, tilted) * cos_atan(b_r * alpha_r)
    else:
        moment = _turning(c, o, spin, b_r * alpha_r, pure_y.mu_y, g_yk)
        trail = trail * turn_slip.zeta_5(c, o, spin)
    moment = moment - trail * fy_prime
    if np.any(c.SSZ1) or np.any(c.SSZ2) or np.any(c.SSZ3) or np.any(c.SSZ4):
        arm = c.SSZ1 + c.SSZ2 * fy / c.FNOMIN + (c.SSZ3 + c.SSZ4 * o.dfz) * o.gamma
        moment = moment + c.UNLOADED_RADIUS * arm * c.LS * fx
    return moment


def _equivalent(c: Coefficients, angle: Value, other: Value) -> Value:
    """Slip angle that has the same effect as this angle with the slip of the other direction."""
    if np.any(c.TAN_ALPHA):  # tangents already (4.E77, 4.E78)
        return np.sqrt(angle * angle + other) * sign(angle)
    tangent = np.tan(angle)
    return np.arctan(np.sqrt(tangent * tangent + other)) * sign(angle)


def _force_with_trail(
    c: Coefficients, o: OperatingPoint, pure_y: PureY, spin: Spin | None
) -> Value:
    """The part of Fy0 that acts at the trail: without camber and spin (4.E74); of 5.2 all."""
    if spin is None and (c.law != LATEST or not np.any(o.gamma)):
        return pure_y.fy0
    return lateral(c, o._replace(gamma=0.0)).fy0


def _trail(c: Coefficients, o: OperatingPoint, alpha_t: Value, alpha_eq: Value) -> Value:
    """Pneumatic trail t [m] (4.E73; A58, A60)."""
    load = c.QBZ1 + (c.QBZ2 + c.QBZ3 * o.dfz) * o.dfz
    b_t = load * (1.0 + c.QBZ4 * o.gamma + c.QBZ5 * np.abs(o.gamma)) * c.LKY / nonzero(c.LMUY)
    skew = (c.QEZ4 + c.QEZ5 * o.gamma) * (2.0 / np.pi) * np.arctan(b_t * c.QCZ1 * alpha_t)
    e_t = (c.QEZ1 + (c.QEZ2 + c.QEZ3 * o.dfz) * o.dfz) * (1.0 + skew)
    e_t = capped(c, e_t)
    d_t = (c.QDZ1 + c.QDZ2 * o.dfz) * (1.0 - c.PPZ1 * o.dpi)
    d_t = d_t * (1.0 + c.QDZ3 * o.gamma + c.QDZ4 * o.gamma * o.gamma)
    # FNOMIN, not LFZO FNOMIN: MF-Tyre multiplies the trail by LFZO once more.
    d_t = d_t * o.fz * (c.UNLOADED_RADIUS / c.FNOMIN) * c.LTR
    return d_t * np.cos(curve_angle(c.QCZ1, b_t, e_t, alpha_eq)) * cos_course(o)


def _turning(
    c: Coefficients, o: OperatingPoint, spin: Spin, slope: Value, mu_y: Value, g_yk: Value
) -> Value:
    """Residual moment [Nm] with turn slip, the spin by camber included (4.E44 to 4.E47)."""
    shape, size = turn_slip.residual_moment(c, o, spin, mu_y, g_yk)
    rest = (c.QDZ6 + c.QDZ7 * o.dfz) * c.LRES * turn_slip.zeta_2(c, o, spin)
    rest = o.fz * c.UNLOADED_RADIUS * rest * c.LMUY * sign(o.vx) * np.cos(o.alpha)
    angle = np.arctan(slope * turn_slip.zeta_6(c, o, spin))
    return (rest + size) * np.cos(shape * angle)


def _residual(c: Coefficients, o: OperatingPoint) -> Value:
    """Peak D_r [Nm] of the residual moment (4.E47)."""
    camber = (c.QDZ8 + c.QDZ9 * o.dfz) * (1.0 + c.PPZ2 * o.dpi)
    camber = camber + (c.QDZ10 + c.QDZ11 * o.dfz) * np.abs(o.gamma)
    peak = (c.QDZ6 + c.QDZ7 * o.dfz) * c.LRES + camber * o.gamma * c.LKZC
    return o.fz * c.UNLOADED_RADIUS * peak * c.LMUY * sign(o.vx) * np.cos(o.alpha)


def overturning(c: Coefficients, o: OperatingPoint, fy: Value) -> Value:
    """Mx [Nm] (equation 49 of the draft of the article, with QSX12 to QSX14).

    In 5.2 it has three coefficients, and LMX scales only camber and side force.
    """
    if c.law != LATEST:
        loaded = (c.QSX3 * fy / c.FNOMIN - c.QSX2 * o.gamma) * c.LMX
        return c.UNLOADED_RADIUS * o.fz * (c.QSX1 * c.LVMX + loaded)
    load, side = o.fz / c.FNOMIN, fy / c.FNOMIN
    mixed = np.cos(c.QSX5 * np.arctan((c.QSX6 * load) ** 2))
    mixed = c.QSX4 * mixed * np.sin(c.QSX7 * o.gamma + c.QSX8 * np.arctan(c.QSX9 * side))
    tilt = c.QSX2 * (1.0 + c.PPMX1 * o.dpi) + c.QSX12 * np.abs(o.gamma)
    per_load = c.QSX1 * c.LVMX - tilt * o.gamma + c.QSX3 * side + mixed
    per_load = per_load + c.QSX10 * np.arctan(c.QSX11 * load) * o.gamma
    per_side = c.QSX13 + c.QSX14 * np.abs(o.gamma)
    return c.UNLOADED_RADIUS * c.LMX * (o.fz * per_load + fy * per_side)


def rolling_resistance(c: Coefficients, o: OperatingPoint, fx: Value) -> Value:
    """My [Nm] at a longitudinal force fx [N]; in 5.2 a share of the load."""
    speed = np.abs(o.vx / nonzero(c.LONGVL))
    share = c.QSY1 + c.QSY2 * fx / c.FNOMIN + c.QSY3 * speed + c.QSY4 * speed**4
    if c.law != LATEST:
        force = o.fz * share
    else:
        load = o.fz / c.FNOMIN
        camber = (c.QSY5 + c.QSY6 * load) * o.gamma * o.gamma
        force = c.FNOMIN * (share + camber) * load**c.QSY7 * (1.0 + o.dpi) ** c.QSY8
    return -c.UNLOADED_RADIUS * c.LMY * sign(o.vx) * force
