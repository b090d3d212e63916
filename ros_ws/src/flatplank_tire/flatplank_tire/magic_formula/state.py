# SPDX-License-Identifier: Apache-2.0
"""Operating point of the Magic Formula and the small functions that all its parts share."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flatplank_tire.magic_formula.coefficients import Coefficients

EPSILON = 1e-6
"""Keeps a quotient finite (book: epsilon_x, epsilon_y, epsilon_K) [N or N/rad]."""

Value = Any
"""A float or a numpy array; everything broadcasts."""


class OperatingPoint(NamedTuple):
    """Operating point of the contact. Angles [rad], kappa [-], fz [N], speed [m/s]; ISO W."""

    fz: Value
    kappa: Value
    alpha: Value
    gamma: Value
    dfz: Value
    dpi: Value
    vx: Value


def operating_point(
    c: Coefficients,
    fz: Value,
    kappa: Value,
    alpha: Value,
    gamma: Value,
    pressure: Value,
    vx: Value,
) -> OperatingPoint:
    """Operating point with normalised changes of load (4.E2a) and pressure (4.E2b).

    Pressure [Pa], the others as in `OperatingPoint`; a negative load counts as zero.
    """
    fz = np.maximum(fz, 0.0)
    fz0 = c.LFZO * c.FNOMIN
    dpi = np.subtract(pressure, c.NOMPRES) / c.NOMPRES
    return OperatingPoint(fz, kappa, alpha, gamma, (fz - fz0) / fz0, dpi, vx)


def cos_course(o: OperatingPoint) -> Value:
    """cos(alpha') (4.E6): forward speed over the speed of the wheel, kept finite at rest."""
    return o.vx / (np.abs(o.vx / np.cos(o.alpha)) + EPSILON)


def sign(x: Value) -> Value:
    """Sign with sign(0) = +1, as MF-Tyre has it."""
    return np.where(np.less(x, 0.0), -1.0, 1.0)


def away_from_zero(x: Value) -> Value:
    """`x` moved by EPSILON away from zero, to divide by."""
    return x + EPSILON * sign(x)


def nonzero(x: Value) -> Value:
    """`x`, or EPSILON where it is 0: a scaling factor of 0 that a quotient has below."""
    return np.where(x == 0.0, EPSILON, x)


def curve_angle(c: Value, b: Value, e: Value, x: Value) -> Value:
    """C atan(B x - E (B x - atan(B x))): the argument of the sine or cosine."""
    bx = b * x
    if not np.any(e):
        return c * np.arctan(bx)
    return c * np.arctan(bx - e * (bx - np.arctan(bx)))


def cos_atan(x: Value) -> Value:
    """cos(atan(x)) without a trigonometric function."""
    return 1.0 / np.sqrt(1.0 + x * x)


def slip_angle(c: Coefficients, o: OperatingPoint) -> Value:
    """alpha, or tan(alpha) (4.E3), as the switch TAN_ALPHA says."""
    return np.tan(o.alpha) if np.any(c.TAN_ALPHA) else o.alpha


def capped(c: Coefficients, e: Value) -> Value:
    """A curvature factor of at most 1, unless the switch CAP_E is 0."""
    return np.minimum(e, 1.0) if np.any(c.CAP_E) else e


def digressive(c: Coefficients, lmu: Value) -> Value:
    """lambda_mu' (4.E8), which scales the vertical shifts."""
    return c.A_MU * lmu / nonzero(1.0 + (c.A_MU - 1.0) * lmu)
