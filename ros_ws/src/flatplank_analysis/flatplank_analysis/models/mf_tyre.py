# SPDX-License-Identifier: Apache-2.0
"""Magic Formula with relaxation: as in MF-Tyre, and with a contact point on a spring.

MF-Tyre (section 7.3): the slips that enter the Magic Formula are those of the contact point:
kappa' = u / sigma_x and alpha' = v / sigma_y with sigma du + u |dx| = sigma ds (Pacejka section
7.2); the relaxation lengths follow load, pressure and camber.

Contact point: it slips by kappa' and deflects the carcass spring: C_x u = Fx(kappa'),
du = ds - kappa' |dx|. At small slip this is MF-Tyre with sigma_x = K_x / C_x; at larger slip the
curve is flatter and the lag shorter, (dFx/dkappa') / C_x. Source: Pacejka (2012) section 7.2,
single contact point with the full steady force; Pacejka and Besselink (1997), Magic Formula tyre
model with transient properties, Vehicle System Dynamics 27 (supplement).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from flatplank_tire.magic_formula import (
    Coefficients,
    OperatingPoint,
    combined,
    operating_point,
    pure,
    steady,
)
from flatplank_tire.magic_formula import structure as shape
from flatplank_tire.magic_formula.combined import SteadyForces
from flatplank_tire.magic_formula.state import Value

from .base import SPEED, RunInputs
from .linear import deflection

SHORTEST = 5e-3
"""Relaxation length where the curve no longer rises [m]: no spring can hold the contact point."""
NEWTON = 3
SMALL = 1e-5
"""Slip step for the slope of the curve [-]."""
MOST = 0.02
"""Largest change of the slip in one Newton step [-]."""


@dataclass(frozen=True)
class MFTyre:
    """Forces of a `.tir` parameter set with relaxation lengths that do not depend on the slip."""

    coefficients: Coefficients

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (1, runs, samples); `params` is not used."""
        return self.simulate_all(inputs)["fx"][None]

    def simulate_all(self, inputs: RunInputs) -> dict[str, np.ndarray]:
        """All outputs: "fx", "fy" [N], "mz" [Nm], each (runs, samples)."""
        c, o = self.coefficients, self._point(inputs)
        start = _at_start(c, o)
        first = (inputs.start_fx - start.fx) / start.kxk
        kappa = _contact_slip(inputs.travel, inputs.slip_x, shape.relaxation_x(c, o), first)
        forces = steady(c, o._replace(kappa=kappa, alpha=self.contact_alpha(inputs)))
        return {n: np.broadcast_to(getattr(forces, n), inputs.shape) for n in ("fx", "fy", "mz")}

    def contact_alpha(self, inputs: RunInputs) -> np.ndarray:
        """Side slip angle of the contact point [rad]; the wheel's own without a sigma_y."""
        c, o = self.coefficients, self._point(inputs)
        sigma_y = shape.relaxation_y(c, o)
        if not np.all(np.isfinite(sigma_y)):
            return inputs.alpha if np.any(inputs.alpha) else 0.0
        forces = _at_start(c, o)
        first = (inputs.start_fy - forces.fy) / forces.kya
        return np.arctan(_contact_slip(inputs.travel, inputs.slip_y, sigma_y, first))

    def _point(self, inputs: RunInputs) -> OperatingPoint:
        """Operating points at zero slip; angles that are zero throughout are scalars (faster)."""
        gamma = inputs.gamma if np.any(inputs.gamma) else 0.0
        c = self.coefficients
        return operating_point(c, inputs.fz, 0.0, 0.0, gamma, inputs.pressure, SPEED)


def _contact_slip(
    travel: np.ndarray, slip: np.ndarray, sigma: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """Slip of the contact point from a start value (runs,)."""
    sigma = np.broadcast_to(sigma, travel.shape)
    return deflection(travel, slip, sigma, start * sigma[:, 0]) / sigma


def _at_start(c: Coefficients, o: OperatingPoint) -> SteadyForces:
    """Forces and slip stiffnesses at sample 0 (runs,): the tangent that has the start force."""
    return steady(c, OperatingPoint(*(v[..., 0] if np.ndim(v) else v for v in o)))


class ContactPointMF(MFTyre):
    """Fx of a `.tir` parameter set with a relaxation length that follows the slip."""

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (1, runs, samples); side slip relaxes as in MF-Tyre."""
        return self._march(inputs)[1][None]

    def simulate_all(self, inputs: RunInputs) -> dict[str, np.ndarray]:
        """All outputs: "fx", "fy" [N], "mz" [Nm], each (runs, samples)."""
        slip, fx = self._march(inputs)
        o = self._point(inputs)._replace(kappa=slip, alpha=self.contact_alpha(inputs))
        forces = steady(self.coefficients, o)
        return {"fx": fx} | {
            n: np.broadcast_to(getattr(forces, n), fx.shape) for n in ("fy", "mz")
        }

    def _march(self, inputs: RunInputs) -> tuple[np.ndarray, np.ndarray]:
        """Slip of the contact point [-] and Fx [N], each (runs, samples)."""
        c = self.coefficients
        o = self._point(inputs)._replace(alpha=self.contact_alpha(inputs))
        spring = np.broadcast_to(shape.stiffness_x(c, o), inputs.shape)
        points = _by_sample(o, inputs.shape)
        slips, forces = np.empty(inputs.shape), np.empty(inputs.shape)
        at = started(partial(_curve, c, points[0]), np.zeros(len(slips)), inputs.start_fx)
        moved = zip(points, inputs.travel.T, inputs.slip_x.T, spring.T, strict=True)
        for i, (point, travel, slid, stiffness) in enumerate(moved):
            at = advanced(partial(_curve, c, point), travel, slid, stiffness, at)
            slips[:, i], forces[:, i] = at.slip, at.force
        return slips, forces


class Contact(NamedTuple):
    """Contact point: slip [-], force [N], slope of its curve [N]."""

    slip: Value
    force: Value
    slope: Value


Curve = Callable[[Value], tuple[Value, Value]]
"""slip [-] -> force [N] and slope [N] of the steady curve"""


def advanced(curve: Curve, travel: Value, slid: Value, stiffness: Value, at: Contact) -> Contact:
    """The contact point after an increment of travel [m] and slip [m], on a spring [N/m]."""
    late = late_weight(travel, np.maximum(at.slope / stiffness, SHORTEST)) * travel
    goal = slid - (travel - late) * at.slip
    slip = at.slip
    for _ in range(NEWTON):
        force, slope = curve(slip)
        rising = slope > SHORTEST * stiffness
        lag = np.where(rising, slope / stiffness, SHORTEST)
        by_force = (force - at.force) / stiffness
        drawn = np.where(rising, by_force, SHORTEST * (slip - at.slip))
        error = goal - drawn - late * slip
        slip = slip + np.clip(error / (lag + late), -MOST, MOST)
    return Contact(slip, *curve(slip))


def started(curve: Curve, zero: Value, force: Value) -> Contact:
    """The contact point where the curve gives `force` [N], on the branch through zero slip."""
    slip = zero
    _, steepest = curve(slip)
    for _ in range(12):
        found, slope = curve(slip)
        slope = np.maximum(slope, 0.05 * steepest)
        slip = np.clip(slip + np.clip((force - found) / slope, -MOST, MOST), -0.2, 0.2)
    return Contact(slip, *curve(slip))


def _by_sample(o: OperatingPoint, full: tuple[int, ...]) -> list[OperatingPoint]:
    """One operating point (runs,) per sample."""
    rows = [
        np.moveaxis(np.broadcast_to(v, full), -1, 0) if np.ndim(v) else [v] * full[1] for v in o
    ]
    return [OperatingPoint(*values) for values in zip(*rows, strict=True)]


def _curve(c: Coefficients, o: OperatingPoint, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fx [N] and dFx/dkappa [N] at a slip, each of its shape."""
    force = longitudinal_force(c, o, np.stack([slip, slip + SMALL]))
    return force[0], (force[1] - force[0]) / SMALL


def longitudinal_force(c: Coefficients, o: OperatingPoint, slip: Value) -> Value:
    """Fx [N] at a slip, the other inputs being those of the operating point."""
    at = o._replace(kappa=slip)
    return pure.longitudinal(c, at).fx0 * combined.weight_x(c, at)


def late_weight(travel: Value, sigma: Value) -> Value:
    """Weight of the end of an increment, 1/(1 - exp(-r)) - 1/r with r = travel / sigma.

    It is 1/2 for short increments and approaches 1 for long ones.
    """
    ratio = np.maximum(travel / sigma, 1e-4)
    return -1.0 / np.expm1(-ratio) - 1.0 / ratio
