# SPDX-License-Identifier: Apache-2.0
"""Combined slip: the weighting of Fx by alpha and of Fy by kappa (4.E50 to 4.E67)."""

from __future__ import annotations

import numpy as np

from . import turn_slip
from .coefficients import Coefficients
from .state import OperatingPoint, Value, capped, cos_atan, curve_angle, slip_angle
from .turn_slip import Spin


def weight_x(c: Coefficients, o: OperatingPoint) -> Value:
    """G_xa: share of Fx0 that is left at this slip angle (4.E51 to 4.E57)."""
    b = (c.RBX1 + c.RBX3 * o.gamma * o.gamma) * cos_atan(c.RBX2 * o.kappa) * c.LXAL
    e = capped(c, c.REX1 + c.REX2 * o.dfz)
    return _weight(c.RCX1, b, e, slip_angle(c, o), c.RHX1)


def weight_y(c: Coefficients, o: OperatingPoint) -> Value:
    """G_yk: share of Fy0 that is left at this longitudinal slip (4.E59 to 4.E65)."""
    tilt = cos_atan(c.RBY2 * (slip_angle(c, o) - c.RBY3))
    b = (c.RBY1 + c.RBY4 * o.gamma * o.gamma) * tilt * c.LYKA
    e = capped(c, c.REY1 + c.REY2 * o.dfz)
    return _weight(c.RCY1, b, e, o.kappa, c.RHY1 + c.RHY2 * o.dfz)


def side_force_by_kappa(
    c: Coefficients, o: OperatingPoint, mu_y: Value, spin: Spin | None = None
) -> Value:
    """S_Vyk (4.E66, 4.E67) [N]: the lateral force that braking and driving bring (plysteer)."""
    if not (np.any(c.RVY1) or np.any(c.RVY2) or np.any(c.RVY3)):
        return 0.0
    d = (
        mu_y
        * o.fz
        * (c.RVY1 + c.RVY2 * o.dfz + c.RVY3 * o.gamma)
        * cos_atan(c.RVY4 * slip_angle(c, o))
    )
    peak = 1.0 if spin is None else turn_slip.peak_y(c, o, spin)
    return d * np.sin(c.RVY5 * np.arctan(c.RVY6 * o.kappa)) * c.LVYKA * peak


def _weight(c: Value, b: Value, e: Value, slip: Value, shift: Value) -> Value:
    if not np.any(shift):
        return np.cos(curve_angle(c, b, e, slip))
    return np.cos(curve_angle(c, b, e, slip + shift)) / np.cos(curve_angle(c, b, e, shift))
