# SPDX-License-Identifier: Apache-2.0
"""Magic Formula at one contact point that hangs on the carcass spring: relaxation over slip.

The contact point slips by kappa' and pulls the spring: C_x u = Fx(kappa'), du = ds - kappa' |dx|.
At small slip this is MF-Tyre with sigma_x = K_x / C_x; at larger slip the curve is flatter and
the lag shorter, (dFx/dkappa') / C_x. Source: Pacejka (2012) section 7.2, single contact point
with the full steady force; Pacejka and Besselink (1997), Magic Formula tyre model with transient
properties, Vehicle System Dynamics 27 (supplement).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .base import RunInputs, column
from .magic_formula import Coefficients, OperatingPoint, combined, pure
from .magic_formula import structure as shape
from .mf_tyre import MFTyre
from .nonlinear import late_weight

SHORTEST = 5e-3
"""Relaxation length where the curve no longer rises [m]: a spring cannot hold a point there."""
NEWTON = 3
SMALL = 1e-5
"""Slip over which the slope of the curve is taken [-]."""
MOST = 0.02
"""Largest change of the slip in one Newton step [-]."""


@dataclass(frozen=True)
class ContactPointMF(MFTyre):
    """Fx of a `.tir` parameter set with a relaxation length that follows the slip."""

    name: str = "mf_contact_point"

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (lanes, runs, samples); side slip relaxes as in MF-Tyre."""
        shape_of = (len(params), *inputs.shape)
        changed = {name: column(params, i)[..., None] for i, name in enumerate(self.free)}
        c = self.coefficients.replaced(changed)
        o = self._point(c, inputs)._replace(alpha=self.contact_alpha(c, inputs))
        spring = np.broadcast_to(shape.stiffness_x(c, o), shape_of)
        flat = c.at(0)
        points = _by_sample(o, shape_of)
        slip = _start(flat, points[0], np.broadcast_to(inputs.start_fx, shape_of[:2]))
        out = np.empty((shape_of[2], *shape_of[:2]))
        force, slope = _curve(flat, points[0], slip)
        moved = zip(inputs.travel.T, inputs.slip_x.T, np.moveaxis(spring, -1, 0), strict=True)
        for n, (travel, slid, stiffness) in enumerate(moved):
            held, before = force, slip
            late = late_weight(travel, np.maximum(slope / stiffness, SHORTEST)) * travel
            goal = slid - (travel - late) * before
            for _ in range(NEWTON):
                force, slope = _curve(flat, points[n], slip)
                rising = slope > SHORTEST * stiffness
                lag = np.where(rising, slope / stiffness, SHORTEST)
                drawn = np.where(rising, (force - held) / stiffness, SHORTEST * (slip - before))
                error = goal - drawn - late * slip
                slip = slip + np.clip(error / (lag + late), -MOST, MOST)
            force, slope = _curve(flat, points[n], slip)
            out[n] = force
        return np.moveaxis(out, 0, -1)


def _by_sample(o: OperatingPoint, full: tuple[int, ...]) -> list[OperatingPoint]:
    """One operating point (lanes, runs) per sample."""
    rows = [
        np.moveaxis(np.broadcast_to(v, full), -1, 0) if np.ndim(v) else [v] * full[2] for v in o
    ]
    return [OperatingPoint(*values) for values in zip(*rows, strict=True)]


def _curve(c: Coefficients, o: OperatingPoint, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fx [N] and dFx/dkappa [N] at a slip, each of its shape."""
    two = o._replace(kappa=np.stack([slip, slip + SMALL]))
    force = pure.longitudinal(c, two).fx0 * combined.weight_x(c, two)
    return force[0], (force[1] - force[0]) / SMALL


def _start(c: Coefficients, o: OperatingPoint, force: np.ndarray) -> np.ndarray:
    """Slip at which the curve gives `force`, on the branch through zero slip."""
    slip = np.zeros(force.shape)
    _, steepest = _curve(c, o, slip)
    for _ in range(12):
        found, slope = _curve(c, o, slip)
        slope = np.maximum(slope, 0.05 * steepest)
        slip = np.clip(slip + np.clip((force - found) / slope, -MOST, MOST), -0.2, 0.2)
    return slip
