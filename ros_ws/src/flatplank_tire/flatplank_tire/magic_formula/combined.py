# SPDX-License-Identifier: Apache-2.0
"""Combined slip: the weighting of Fx and Fy (4.E50 to 4.E67), and the steady forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flatplank_tire.magic_formula import moment, pure, turn_slip
from flatplank_tire.magic_formula.coefficients import Coefficients
from flatplank_tire.magic_formula.state import (
    OperatingPoint,
    Value,
    capped,
    cos_atan,
    curve_angle,
    operating_point,
    slip_angle,
)
from flatplank_tire.magic_formula.structure import rolling
from flatplank_tire.magic_formula.turn_slip import Spin, spin_of


def weight_x(c: Coefficients, o: OperatingPoint) -> Value:
    """G_xa: remaining share of Fx0 at this slip angle (4.E51 to 4.E57)."""
    b = (c.RBX1 + c.RBX3 * o.gamma * o.gamma) * cos_atan(c.RBX2 * o.kappa) * c.LXAL
    e = capped(c, c.REX1 + c.REX2 * o.dfz)
    return _weight(c.RCX1, b, e, slip_angle(c, o), c.RHX1)


def weight_y(c: Coefficients, o: OperatingPoint) -> Value:
    """G_yk: remaining share of Fy0 at this longitudinal slip (4.E59 to 4.E65)."""
    tilt = cos_atan(c.RBY2 * (slip_angle(c, o) - c.RBY3))
    b = (c.RBY1 + c.RBY4 * o.gamma * o.gamma) * tilt * c.LYKA
    e = capped(c, c.REY1 + c.REY2 * o.dfz)
    return _weight(c.RCY1, b, e, o.kappa, c.RHY1 + c.RHY2 * o.dfz)


def side_force_by_kappa(
    c: Coefficients, o: OperatingPoint, mu_y: Value, spin: Spin | None = None
) -> Value:
    """S_Vyk (4.E66, 4.E67) [N]: lateral force by braking and driving (ply steer)."""
    if not (np.any(c.RVY1) or np.any(c.RVY2) or np.any(c.RVY3)):
        return 0.0
    d = (
        mu_y
        * o.fz
        * (c.RVY1 + c.RVY2 * o.dfz + c.RVY3 * o.gamma)
        * cos_atan(c.RVY4 * slip_angle(c, o))
    )
    peak = 1.0 if spin is None else turn_slip.zeta_2(c, o, spin)
    return d * np.sin(c.RVY5 * np.arctan(c.RVY6 * o.kappa)) * c.LVYKA * peak


def _weight(c: Value, b: Value, e: Value, slip: Value, shift: Value) -> Value:
    if not np.any(shift):
        return np.cos(curve_angle(c, b, e, slip))
    return np.cos(curve_angle(c, b, e, slip + shift)) / np.cos(curve_angle(c, b, e, shift))


PIECE = 4096
"""Samples computed at once: some forty temporaries of this size fit in the second-level cache."""


class SteadyForces(NamedTuple):
    """Fx, Fy [N] and Mz [Nm] at combined slip; slip stiffnesses K_xk [N], K_ya [N/rad]. ISO W."""

    fx: Value
    fy: Value
    mz: Value
    kxk: Value
    kya: Value


def steady(c: Coefficients, o: OperatingPoint, turn_slip: Value | None = None) -> SteadyForces:
    """Forces at combined slip at one operating point (any broadcast shape).

    turn_slip: curvature of the path [1/m], positive to the left; None: left out.
    """
    spin = None
    if turn_slip is not None:
        spin = spin_of(c, o, turn_slip, rolling(c, o, o.vx)[0])
    px, py = pure.longitudinal(c, o, spin), pure.lateral(c, o, spin)
    g_yk = weight_y(c, o)
    fx = px.fx0 * weight_x(c, o)
    fy = py.fy0 * g_yk + side_force_by_kappa(c, o, py.mu_y, spin)
    mz = moment.aligning(c, o, py, px.kxk, g_yk, fx, fy, spin)
    return SteadyForces(fx, fy, mz, px.kxk, py.kya)


def steady_forces(
    c: Coefficients,
    fz: Value,
    kappa: Value = 0.0,
    alpha: Value = 0.0,
    gamma: Value = 0.0,
    pressure: Value | None = None,
    vx: Value = 1.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fx, Fy [N] and Mz [Nm] for arrays of one length (or scalars that broadcast).

    fz [N], kappa [-], alpha and gamma [rad], pressure [Pa] (None: nominal), vx [m/s].
    """
    pressure = c.NOMPRES if pressure is None else pressure
    inputs = [np.asarray(v, float) for v in (fz, kappa, alpha, gamma, pressure, vx)]
    shape = np.broadcast_shapes(*(v.shape for v in inputs))
    flat = [v if v.ndim == 0 else np.broadcast_to(v, shape).ravel() for v in inputs]
    out = np.empty((3, int(np.prod(shape))))
    for begin in range(0, out.shape[1], PIECE):
        piece = slice(begin, begin + PIECE)
        part = (v if v.ndim == 0 else v[piece] for v in flat)
        forces = steady(c, operating_point(c, *part))
        for row, force in zip(out, forces[:3], strict=True):
            row[piece] = force
    return tuple(row.reshape(shape) for row in out)
