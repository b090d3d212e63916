# SPDX-License-Identifier: Apache-2.0
"""Linear transient model: a contact point on a carcass spring (7.1-7.11), in x or in y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import Parameter

from .base import RunInputs, column
from .relaxation import deflection

PARAMETERS = (
    Parameter("sigma", "m", 0.45, 0.005, 5.0, note="thesis (7.7), figure 7.3"),
    Parameter("slip_stiffness", "N", 9e4, 0.0, 1e7, note="thesis (7.3), figure 7.3"),
)


@dataclass(frozen=True)
class LinearX:
    """Fx = C_x u with sigma_x du/dx + u = sigma_x kappa and C_x = C_Fkappa / sigma_x."""

    name: str = "linear"
    parameters: tuple[Parameter, ...] = PARAMETERS

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (lanes, runs, samples)."""
        return _simulate(params, inputs.travel, inputs.slip_x, inputs.start_fx)


@dataclass(frozen=True)
class LinearY:
    """Fy = -C_y v with sigma_y; ISO W: a positive slip angle gives a negative side force."""

    name: str = "linear-y"
    parameters: tuple[Parameter, ...] = (
        Parameter("sigma", "m", 0.45, 0.005, 5.0, note="thesis (7.7) in y; Pacejka (7.7)"),
        Parameter("slip_stiffness", "N/rad", 5e4, 0.0, 1e7, note="Pacejka (7.8)"),
    )

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fy [N] (lanes, runs, samples)."""
        return -_simulate(params, inputs.travel, inputs.slip_y, -inputs.start_fy)


def _simulate(
    params: np.ndarray, travel: np.ndarray, slip: np.ndarray, start: np.ndarray
) -> np.ndarray:
    sigma, stiffness = column(params, 0), column(params, 1)
    spring = stiffness / sigma
    first = start[None, :] / np.where(spring == 0.0, 1.0, spring)
    return spring[..., None] * deflection(travel[None], slip[None], sigma[..., None], first)
