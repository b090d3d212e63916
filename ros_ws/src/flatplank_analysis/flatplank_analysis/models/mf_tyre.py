# SPDX-License-Identifier: Apache-2.0
"""MF-Tyre: the Magic Formula behind first-order relaxation of both slips (section 7.3).

The slips that enter the Magic Formula are those of the contact point: kappa' = u / sigma_x and
alpha' = v / sigma_y with sigma du + u |dx| = sigma ds (Pacejka section 7.2); the relaxation
lengths follow load, pressure and camber.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flatplank_analysis.discovery.parameters import Parameter

from .base import RunInputs, column
from .magic_formula import Coefficients, OperatingPoint, operating_point, steady
from .magic_formula import structure as shape
from .relaxation import deflection

OUTPUTS = ("fx", "fy", "mz")


@dataclass(frozen=True)
class MFTyre:
    """Fx, Fy, Mz of a `.tir` parameter set; `free` names the coefficients that are parameters."""

    coefficients: Coefficients
    free: Sequence[str] = ()
    output: str = "fx"
    speed: float = 0.03
    """Forward speed [m/s]; only its sign and the growth of the radius depend on it."""
    name: str = "mf"
    parameters: tuple[Parameter, ...] = field(init=False)

    def __post_init__(self) -> None:
        values = self.coefficients.__dict__
        made = tuple(
            Parameter(n, "-", float(values[n]), -np.inf, np.inf, note=".tir") for n in self.free
        )
        object.__setattr__(self, "parameters", made)

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Chosen output [N or Nm], (lanes, runs, samples)."""
        return self.simulate_all(params, inputs)[self.output]

    def simulate_all(self, params: np.ndarray, inputs: RunInputs) -> dict[str, np.ndarray]:
        """All outputs: "fx", "fy" [N], "mz" [Nm], each (lanes, runs, samples)."""
        lanes = len(params)
        changed = {name: column(params, i)[..., None] for i, name in enumerate(self.free)}
        c = self.coefficients.replaced(changed)
        o = self._point(c, inputs)
        kappa = _contact_slip(
            inputs.travel, inputs.slip_x, shape.relaxation_x(c, o), _start(c, o, inputs, "fx")
        )
        forces = steady(c, o._replace(kappa=kappa, alpha=self.contact_alpha(c, inputs)))
        full = (lanes, *inputs.shape)
        return {n: np.broadcast_to(getattr(forces, n), full) for n in OUTPUTS}

    def contact_alpha(self, c: Coefficients, inputs: RunInputs) -> np.ndarray:
        """Side slip angle of the contact point [rad]; the wheel's own without a sigma_y."""
        o = self._point(c, inputs)
        sigma_y = shape.relaxation_y(c, o)
        if not np.all(np.isfinite(sigma_y)):
            return inputs.alpha[None] if np.any(inputs.alpha) else 0.0
        first = _start(c, o, inputs, "fy")
        return np.arctan(_contact_slip(inputs.travel, inputs.slip_y, sigma_y, first))

    def _point(self, c: Coefficients, inputs: RunInputs) -> OperatingPoint:
        """Operating points at zero slip; angles that are zero throughout stay scalars (speed)."""
        gamma = inputs.gamma[None] if np.any(inputs.gamma) else 0.0
        return operating_point(
            c, inputs.fz[None], 0.0, 0.0, gamma, inputs.pressure[None], self.speed
        )


def _contact_slip(
    travel: np.ndarray, slip: np.ndarray, sigma: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """Slip of the contact point from a start value (lanes, runs)."""
    sigma = np.broadcast_to(sigma, np.broadcast_shapes(np.shape(sigma), travel[None].shape))
    return deflection(travel[None], slip[None], sigma, start * sigma[..., 0]) / sigma


def _start(c: Coefficients, o: OperatingPoint, inputs: RunInputs, axis: str) -> np.ndarray:
    """Slip that gives the measured start force along the tangent at zero slip (lanes, runs)."""
    first = OperatingPoint(*(v[..., 0] if np.ndim(v) else v for v in o))
    first_c = c.at(0)
    forces = steady(first_c, first)
    if axis == "fx":
        return (inputs.start_fx - forces.fx) / forces.kxk
    return (inputs.start_fy - forces.fy) / forces.kya
