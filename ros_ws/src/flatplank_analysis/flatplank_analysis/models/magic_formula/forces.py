# SPDX-License-Identifier: Apache-2.0
"""Steady forces of the Magic Formula, in pieces that stay in the processor's cache."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from . import combined, moment, pure
from .coefficients import Coefficients
from .state import OperatingPoint, Value, operating_point
from .structure import rolling
from .turn_slip import spin_of

PIECE = 4096
"""Samples in one piece: some forty temporaries of this size fit in the second-level cache."""


class SteadyForces(NamedTuple):
    """Fx, Fy [N] and Mz [Nm] at combined slip; slip stiffnesses K_xk [N], K_ya [N/rad]. ISO W."""

    fx: Value
    fy: Value
    mz: Value
    kxk: Value
    kya: Value


def steady(c: Coefficients, o: OperatingPoint, turn_slip: Value | None = None) -> SteadyForces:
    """Forces at combined slip at one operating point (any broadcast shape).

    turn_slip: curvature of the path [1/m], positive to the left; None: turn slip is
    left out.
    """
    spin = None
    if turn_slip is not None:
        spin = spin_of(c, o, turn_slip, rolling(c, o, o.vx)[0])
    px, py = pure.longitudinal(c, o, spin), pure.lateral(c, o, spin)
    g_yk = combined.weight_y(c, o)
    fx = px.fx0 * combined.weight_x(c, o)
    fy = py.fy0 * g_yk + combined.side_force_by_kappa(c, o, py.mu_y, spin)
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
    for piece in _pieces(out.shape[1]):
        part = (v if v.ndim == 0 else v[piece] for v in flat)
        forces = steady(c, operating_point(c, *part))
        for row, force in zip(out, forces[:3], strict=True):
            row[piece] = force
    return tuple(row.reshape(shape) for row in out)


def _pieces(n: int) -> Iterator[slice]:
    return (slice(i, min(i + PIECE, n)) for i in range(0, n, PIECE))
