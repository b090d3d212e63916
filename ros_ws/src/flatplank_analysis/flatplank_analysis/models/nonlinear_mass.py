# SPDX-License-Identifier: Apache-2.0
"""Nonlinear transient model with the contact patch mass and carcass damping (7.14) as they stand.

For comparison only: at the bench's speed the result differs from the quasi-static one by newtons
in the first millimetres. The steps are implicit, so that their size follows from accuracy alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .base import RunInputs, column
from .contact import patch_relaxation
from .nonlinear import DAMPING_TIME, NonlinearX, start_slip

NEWTON = 4


@dataclass(frozen=True)
class NonlinearMassX(NonlinearX):
    """m_c dV*/dt + k_cx du/dt + c_cx u = F_ss(kappa'); needs the time of every sample."""

    mass: float = 1.0
    """m_c [kg], Table 7.2."""
    damping_time: float = DAMPING_TIME
    name: str = "nonlinear-mass"

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx on the rim [N], c_cx u + k_cx du/dt, (lanes, runs, samples)."""
        law = self.law(params)
        shape = (len(params), inputs.shape[0])
        spring = np.broadcast_to(column(params, 0), shape)
        a = self.geometry.half_length(inputs.fz, inputs.pressure)
        theta = np.abs(law.stiffness()) / (3.0 * self.friction * np.maximum(inputs.fz[:, 0], 1.0))
        slip = start_slip(law, np.broadcast_to(inputs.start_fx, shape))
        u, speed = law.force(slip)[0] / spring, np.zeros(shape)
        out = np.empty((inputs.shape[1], *shape))
        samples = zip(inputs.travel.T, inputs.slip_x.T, inputs.dt.T, a.T, out, strict=True)
        for travel, moved, dt, half, plane in samples:
            if not np.any(dt > 0.0):
                plane[:] = spring * u
                continue
            dt = np.maximum(dt, 1e-9)
            rim = -moved / dt
            damper = self.damping_time * spring
            inertia = self.mass / dt + damper + spring * dt
            known = self.mass / dt * speed + (damper + spring * dt) * rim - spring * u
            before, share = slip, dt / inertia
            for _ in range(NEWTON):
                force, slope = law.force(slip)
                middle = 0.5 * (slip + before)
                sigma = patch_relaxation(middle, theta, half)
                error = sigma * (slip - before) + travel * middle + share * (known + force)
                rate = sigma + 0.5 * travel + share * np.maximum(slope, 0.0)
                slip = slip - error / rate
            speed = (known + law.force(slip)[0]) / inertia
            u = u + dt * (speed - rim)
            plane[:] = spring * u + damper * (speed - rim)
        return np.moveaxis(out, 0, -1)
