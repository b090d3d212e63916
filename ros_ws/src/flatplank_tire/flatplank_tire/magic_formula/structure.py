# SPDX-License-Identifier: Apache-2.0
"""Radii, deflection, contact patch, stiffnesses and relaxation lengths.

Source: Besselink, Schmeitz, Pacejka (2010), equations 1 to 10 and 17 to 19; thesis (7.20), (7.21);
relaxation lengths of 5.2: Pacejka 2006, as in the manual of MF-Tyre 5.2.
"""

from __future__ import annotations

import numpy as np

from flatplank_tire.magic_formula.coefficients import Coefficients
from flatplank_tire.magic_formula.pure import cornering_stiffness, longitudinal_stiffness
from flatplank_tire.magic_formula.state import OperatingPoint, Value, nonzero


def vertical_stiffness(c: Coefficients, dpi: Value) -> Value:
    """C_z [N/m] at the nominal load, over pressure (7.21)."""
    return c.VERTICAL_STIFFNESS * (1.0 + c.PFZ1 * dpi)


def effective_radius(c: Coefficients, o: OperatingPoint, omega: Value) -> Value:
    """Effective rolling radius R_e [m] at wheel speed omega [rad/s].

    Q_REA and Q_REG [1/rad2] add the changes by side slip and camber; they are zero in MF-Tyre.
    """
    load = o.fz / c.FNOMIN
    shape = c.DREFF * np.arctan(c.BREFF * load) + c.FREFF * load
    tilt = c.UNLOADED_RADIUS * (c.Q_REA * o.alpha * o.alpha + c.Q_REG * o.gamma * o.gamma)
    return free_radius(c, omega) - c.FNOMIN / vertical_stiffness(c, o.dpi) * shape + tilt


def free_radius(c: Coefficients, omega: Value) -> Value:
    """Radius of the unloaded tire at speed [m]."""
    growth = omega * c.UNLOADED_RADIUS / nonzero(c.LONGVL)
    return c.UNLOADED_RADIUS * (c.Q_RE0 + c.Q_V1 * growth * growth)


def rolling(c: Coefficients, o: OperatingPoint, vx: Value) -> tuple[Value, Value]:
    """R_e [m] and omega [rad/s] that agree with each other: omega = (1 + kappa) vx / R_e."""
    omega = 0.0
    radius = effective_radius(c, o, omega)
    # the growth with speed is some 0.1 mm: the fixed point converges in a few iterations
    for _ in range(40):
        omega = (1.0 + o.kappa) * vx / radius
        before, radius = radius, effective_radius(c, o, omega)
        if np.all(np.abs(radius - before) < 1e-14):
            break
    return radius, omega


def deflection(c: Coefficients, o: OperatingPoint, omega: Value, fx: Value, fy: Value) -> Value:
    """Deflection rho [m] at which the tire carries fz; the form is finite with Q_FZ2 = 0, too."""
    gain = 1.0 + c.Q_V2 * (c.UNLOADED_RADIUS / nonzero(c.LONGVL)) * np.abs(omega)
    gain = gain - (c.Q_FCX * fx / c.FNOMIN) ** 2 - (c.Q_FCY * fy / c.FNOMIN) ** 2
    load = o.fz / (gain * (1.0 + c.PFZ1 * o.dpi) * c.FNOMIN)
    slope = c.VERTICAL_STIFFNESS * c.UNLOADED_RADIUS / c.FNOMIN
    q_fz1 = np.sqrt(slope * slope - 4.0 * c.Q_FZ2)
    return c.UNLOADED_RADIUS * 2.0 * load / (q_fz1 + np.sqrt(q_fz1**2 + 4.0 * c.Q_FZ2 * load))


def contact_half_length(c: Coefficients, o: OperatingPoint) -> Value:
    """Half contact length a [m] (7.20)."""
    rho = o.fz / (vertical_stiffness(c, o.dpi) * c.UNLOADED_RADIUS)
    return c.UNLOADED_RADIUS * (c.Q_RA2 * rho + c.Q_RA1 * np.sqrt(rho))


def contact_half_width(c: Coefficients, o: OperatingPoint) -> Value:
    """Half contact width b [m]."""
    rho = o.fz / (vertical_stiffness(c, o.dpi) * c.UNLOADED_RADIUS)
    return c.WIDTH * (c.Q_RB2 * rho + c.Q_RB1 * np.cbrt(rho))


def stiffness_x(c: Coefficients, o: OperatingPoint) -> Value:
    """Overall longitudinal stiffness C_x [N/m]; NaN where the tire has none."""
    load = 1.0 + c.PCFX1 * o.dfz + c.PCFX2 * o.dfz * o.dfz
    return known(c.LONGITUDINAL_STIFFNESS) * load * (1.0 + c.PCFX3 * o.dpi)


def stiffness_y(c: Coefficients, o: OperatingPoint) -> Value:
    """Overall lateral stiffness C_y [N/m]; NaN where the tire has none."""
    load = 1.0 + c.PCFY1 * o.dfz + c.PCFY2 * o.dfz * o.dfz
    return known(c.LATERAL_STIFFNESS) * load * (1.0 + c.PCFY3 * o.dpi)


def known(stiffness: Value) -> Value:
    """A stiffness [N/m]; NaN for 0, which files write for one that was not measured."""
    return np.where(stiffness == 0.0, np.nan, stiffness)


def relaxation_x(c: Coefficients, o: OperatingPoint) -> Value:
    """sigma_x [m]: K_xk / C_x (7.7), or the formula of 5.2 where its coefficients are given."""
    if not np.any(c.PTX1):
        return np.abs(longitudinal_stiffness(c, o) / stiffness_x(c, o))
    size = (c.PTX1 + c.PTX2 * o.dfz) * np.exp(-c.PTX3 * o.dfz) * c.LSGKP
    return np.abs(c.UNLOADED_RADIUS * o.fz / c.FNOMIN * size)


def relaxation_y(c: Coefficients, o: OperatingPoint) -> Value:
    """sigma_y [m]: K_ya / C_y, or the formula of 5.2 where its coefficients are given."""
    if not np.any(c.PTY1):
        return np.abs(cornering_stiffness(c, o) / stiffness_y(c, o))
    fz0 = c.LFZO * c.FNOMIN
    shape = np.sin(2.0 * np.arctan2(o.fz / fz0, np.abs(c.PTY2)))
    camber = 1.0 - c.PKY3 * np.abs(o.gamma * c.LGAY)
    return np.abs(c.PTY1 * shape * camber * c.UNLOADED_RADIUS * c.LFZO * c.LSGAL)
