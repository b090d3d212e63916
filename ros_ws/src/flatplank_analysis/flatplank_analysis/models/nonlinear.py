# SPDX-License-Identifier: Apache-2.0
"""Nonlinear transient model: a contact patch with its own relaxation on a spring (7.13-7.24).

Quasi-static in the patch mass: at 0.03 m/s the mass of 1 kg moves nothing that a force of newtons
could show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatplank_analysis.discovery.parameters import Parameter

from . import kernel
from .base import RunInputs, column
from .contact import LOWEST_SHARE, TOYO, ContactGeometry, patch_relaxation
from .steady_law import SteadyLaw, TableLaw, table_law

LawMaker = Callable[[np.ndarray], SteadyLaw]
"""Law for parameters (lanes, p): the same table for all lanes, or one that depends on them."""

CARCASS = Parameter("c_cx", "N/m", 2e5, 2e4, 5e6, note="thesis (7.14), figure 7.24")
NEWTON = kernel.NEWTON
"""Newton steps per sample: the law is nearly straight over one increment."""


def _default_law(params: np.ndarray) -> SteadyLaw:
    slips = np.array([-0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1])
    return table_law(slips, 3500.0 * np.sin(1.4 * np.arctan(18.0 * slips)))


def _default_law_y(params: np.ndarray) -> SteadyLaw:
    slips = np.linspace(-0.2, 0.2, 21)
    return table_law(slips, -3300.0 * np.sin(1.4 * np.arctan(11.0 * slips)))


@dataclass(frozen=True)
class NonlinearX:
    """Fx from F_ss(kappa'): sigma_c dkappa' + kappa' |dx| = ds - du, c_cx u = F_ss (quasi-static).

    `friction` mu [-]; `tread_stiffness` c_px [N/m2]; None ties it to the law, 2 c_px a^2 = C_Fk
    (brush model), so that the fit cannot hide in a corner where both compensate.
    """

    law: LawMaker = _default_law
    geometry: ContactGeometry = TOYO
    friction: float = 0.993
    tread_stiffness: float | None = None
    damping_time: float = 0.0
    longitudinal: bool = True
    """Whether slip also changes the distance that a tread element travels (1 + kappa')."""
    name: str = "nonlinear"
    parameters: tuple[Parameter, ...] = field(default=(CARCASS,))

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (lanes, runs, samples)."""
        law = self.law(params)
        return self._run(law, params, inputs, inputs.slip_x, inputs.start_fx)

    def _run(
        self,
        law: SteadyLaw,
        params: np.ndarray,
        inputs: RunInputs,
        slip: np.ndarray,
        start: np.ndarray,
    ) -> np.ndarray:
        lanes, (runs, _) = len(params), inputs.shape
        carcass = column(params, 0)
        a = self.geometry.half_length(inputs.fz, inputs.pressure)
        limit = 3.0 * self.friction * np.maximum(inputs.fz, 1.0)
        if self.tread_stiffness is None:
            theta = np.abs(law.stiffness())[..., None] / limit
        else:
            theta = (2.0 * self.tread_stiffness * a**2 / limit)[None]
        shape = (lanes, runs)
        stepper = _Stepper(law, np.broadcast_to(1.0 / carcass, shape), self.longitudinal)
        state = start_slip(law, np.broadcast_to(start, shape))
        return stepper.march(state, inputs, slip, a, theta, self.damping_time)


@dataclass(frozen=True)
class NonlinearY(NonlinearX):
    """Fy over the patch's lateral slip; the law gives Fy over tan(alpha'), falling (ISO W)."""

    law: LawMaker = _default_law_y
    longitudinal: bool = False
    name: str = "nonlinear-y"
    parameters: tuple[Parameter, ...] = (
        Parameter("c_cy", "N/m", 1e5, 1e4, 5e6, note="thesis (7.14) in y; Pacejka section 7.3"),
    )

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fy [N] (lanes, runs, samples)."""
        law = _Mirrored(self.law(params))
        return -self._run(law, params, inputs, inputs.slip_y, -inputs.start_fy)


@dataclass(frozen=True)
class _Mirrored:
    """A law with its sign turned, so that the solver sees a rising force in y as in x."""

    law: SteadyLaw

    def force(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        force, slope = self.law.force(slip)
        return -force, -slope

    def stiffness(self) -> np.ndarray:
        return -self.law.stiffness()

    def table(self) -> TableLaw | None:
        table = self.law.table()
        return None if table is None else TableLaw(table.first, table.step, -table.values)


def start_slip(law: SteadyLaw, force: np.ndarray) -> np.ndarray:
    """Contact-patch slip at which the law gives `force` (lanes, runs): the start (7.24)."""
    slip = np.zeros(force.shape)
    steepest = np.abs(law.stiffness()) + 1.0
    for _ in range(30):
        value, slope = law.force(slip)
        slope = np.sign(slope + 1e-300) * np.maximum(np.abs(slope), 0.02 * steepest)
        change = np.clip((value - force) / slope, -0.02, 0.02)
        slip = np.clip(slip - change, -0.2, 0.2)
        if np.max(np.abs(change)) < 1e-12:
            break
    return slip


@dataclass
class _Stepper:
    """Implicit step over one increment, for all lanes and runs at once.

    The weight between both ends of the increment is that of the exponential solution: second order
    where the force relaxes slowly, without ringing where it follows at once. Where the law falls
    so fast that no spring holds the contact point (`kernel.HOLDS`), the slip goes on without it.
    """

    law: SteadyLaw
    compliance: np.ndarray
    longitudinal: bool

    def march(
        self,
        slip: np.ndarray,
        inputs: RunInputs,
        increments: np.ndarray,
        a: np.ndarray,
        theta: np.ndarray,
        damping_time: float,
    ) -> np.ndarray:
        """Force (lanes, runs, samples) from the slip before sample 0 (lanes, runs)."""
        table = self.law.table()
        if table is not None and kernel.compiled is not None:
            return self._march_compiled(table, slip, inputs, increments, a, theta, damping_time)
        force, slope = self.law.force(slip)
        u = force * self.compliance
        out = np.empty((inputs.shape[1], *slip.shape))
        share = _followed(inputs.dt, damping_time).T
        theta = np.broadcast_to(theta, (*theta.shape[:2], inputs.shape[1]))
        known = (inputs.travel.T, increments.T, a.T, share, np.moveaxis(theta, -1, 0))
        for travel, moved, half, follow, limit, plane in zip(*known, out, strict=True):
            compliance = self.compliance * follow
            before, sigma = slip, self._sigma(slip, limit, half)
            late = late_weight(travel, sigma + compliance * np.maximum(slope, 0.0)) * travel
            goal = moved - (travel - late) * slip
            for _ in range(NEWTON):
                sigma = self._sigma(0.5 * (slip + before), limit, half)
                holds = compliance * slope > -kernel.HOLDS * sigma
                drawn = np.where(holds, compliance * force - follow * u, 0.0)
                error = goal - sigma * (slip - before) - late * slip - drawn
                shrink = self._shrink(slip, before, limit, half)
                rate = sigma - np.minimum(shrink, 0.5 * sigma) + late
                slip = slip + error / (rate + compliance * np.maximum(slope, 0.0))
                force, slope = self.law.force(slip)
            plane[:] = force
            u = u + follow * (force * self.compliance - u)
        return np.moveaxis(out, 0, -1)

    def _march_compiled(
        self,
        table: TableLaw,
        slip: np.ndarray,
        inputs: RunInputs,
        increments: np.ndarray,
        a: np.ndarray,
        theta: np.ndarray,
        damping_time: float,
    ) -> np.ndarray:
        values = table.values if table.values.ndim == 3 else table.values[None]
        rows = (inputs.travel, increments, a, _followed(inputs.dt, damping_time))
        assert kernel.compiled is not None, "asked by the caller"
        return kernel.compiled(
            np.ascontiguousarray(slip),
            self.law.force(slip)[0] * self.compliance,
            np.ascontiguousarray(self.compliance),
            *(np.ascontiguousarray(row) for row in rows),
            np.ascontiguousarray(np.atleast_3d(theta)),
            table.first,
            table.step,
            np.ascontiguousarray(values),
            self.longitudinal,
        )

    def _shrink(
        self, slip: np.ndarray, before: np.ndarray, theta: np.ndarray, half: np.ndarray
    ) -> np.ndarray:
        """What the shrinking adhering part takes from the derivative of the error [m]."""
        middle = 0.5 * (slip + before)
        base = np.maximum(1.0 + middle, 0.1) if self.longitudinal else 1.0
        adheres = 1.0 - theta * np.abs(middle) / base > LOWEST_SHARE
        return np.where(adheres, 0.5 * theta * half * np.abs(slip - before), 0.0)

    def _sigma(self, slip: np.ndarray, theta: np.ndarray, half: np.ndarray) -> np.ndarray:
        return patch_relaxation(slip, theta, half, self.longitudinal)


def late_weight(travel: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Weight of the end of an increment, 1/(1 - exp(-r)) - 1/r: 1/2 if short, 1 if long."""
    ratio = np.maximum(travel / sigma, 1e-4)
    return -1.0 / np.expm1(-ratio) - 1.0 / ratio


def _followed(dt: np.ndarray, damping_time: float) -> np.ndarray:
    """Share of the way to its new equilibrium that the damped carcass goes in dt (7.23)."""
    if damping_time <= 0.0:
        return np.ones_like(dt)
    return np.where(dt > 0.0, -np.expm1(-dt / damping_time), 1.0)
