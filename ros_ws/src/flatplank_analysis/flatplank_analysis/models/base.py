# SPDX-License-Identifier: Apache-2.0
"""Inputs of the transient tire models over distance, and the geometry of the contact.

A model is driven by increments of position and angle, not by velocities, so that rest, reverse and
any slip waveform need no special case. Results are (sets, runs, samples): many parameter sets are
computed in one call, for a Jacobian or a whole search step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass(frozen=True)
class ContactGeometry:
    """Vertical stiffness and contact length of one tire. Source: Table 7.2."""

    free_radius: float = 0.318
    """r_0 [m]."""
    vertical_stiffness: float = 2.13e5
    """C_z0 at nominal load and pressure [N/m]."""
    pressure_effect: float = 0.8451
    """p_Fz1 [-]."""
    nominal_pressure: float = 250e3
    """p_0 [Pa]."""
    q_ra1: float = 0.924
    """Coefficient of the root of the deflection in (7.20) [-]."""
    q_ra2: float = 0.120
    """Coefficient of the deflection in (7.20) [-]."""

    def stiffness(self, pressure: np.ndarray | float) -> np.ndarray:
        """C_z [N/m] (7.21) at pressure [Pa]."""
        change = (np.asarray(pressure, float) - self.nominal_pressure) / self.nominal_pressure
        return self.vertical_stiffness * (1.0 + self.pressure_effect * change)

    def half_length(self, fz: np.ndarray | float, pressure: np.ndarray | float) -> np.ndarray:
        """Half contact length a [m] (7.20)."""
        rho = np.asarray(fz, float) / (self.stiffness(pressure) * self.free_radius)
        return self.free_radius * (self.q_ra2 * rho + self.q_ra1 * np.sqrt(rho))


TOYO = ContactGeometry()
"""Geometry of the Toyo of the thesis, a default for studies: that of a campaign is from its tire
record."""
SPEED = 0.03
"""Road speed of models that need one, and LONGVL of general start values [m/s]: the fast speed of
the plank (`machine.FAST`), rounded."""


@dataclass(frozen=True)
class RunInputs:
    """Inputs of the models. Arrays (runs, samples); increments are from the sample before.

    `travel` |dx| of the wheel over the road, in the wheel plane [m]; `slip_x` r_e d(angle) - dx
    [m], that is kappa times travel; `slip_y` tan(alpha) times travel [m]; `fz` [N]; `alpha`,
    `gamma` [rad]; `pressure` [Pa]; `start_fx`, `start_fy` (runs,) [N] the force before sample 0.
    """

    travel: np.ndarray
    slip_x: np.ndarray
    slip_y: np.ndarray
    fz: np.ndarray
    alpha: np.ndarray
    gamma: np.ndarray
    pressure: np.ndarray
    start_fx: np.ndarray
    start_fy: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """(runs, samples)."""
        return self.travel.shape


class TransientModel(Protocol):
    """A tire model that maps parameters and inputs to one force."""

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Force [N] (sets, runs, samples) for params (sets, p) or (sets, p, runs)."""
        ...


def column(params: np.ndarray, index: int) -> np.ndarray:
    """Parameter `index` as (sets, 1), or (sets, runs) when it differs between runs."""
    values = np.asarray(params, float)[:, index]
    return values[:, None] if values.ndim == 1 else values


def slip_inputs(
    distance: np.ndarray,
    kappa: np.ndarray | float,
    fz: np.ndarray | float,
    *,
    alpha: np.ndarray | float = 0.0,
    gamma: np.ndarray | float = 0.0,
    pressure: float = 250e3,
    start_fx: float = 0.0,
    start_fy: float = 0.0,
) -> RunInputs:
    """Inputs of one run at distances [m]; kappa [-], alpha [rad] hold since the sample before."""
    x = np.asarray(distance, float)
    dx = np.diff(x, prepend=x[0])

    def row(value: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(np.asarray(value, float), x.shape)[None, :]

    return RunInputs(
        travel=row(np.abs(dx)),
        slip_x=row(np.asarray(kappa, float) * np.abs(dx)),
        slip_y=row(np.tan(np.asarray(alpha, float)) * np.abs(dx)),
        fz=row(fz),
        alpha=row(alpha),
        gamma=row(gamma),
        pressure=row(pressure),
        start_fx=np.array([start_fx]),
        start_fy=np.array([start_fy]),
    )


def stack_runs(runs: Sequence[RunInputs]) -> RunInputs:
    """Several runs as one; shorter ones are padded with samples without motion."""
    length = max(r.shape[1] for r in runs)

    def join(name: str, rest: bool) -> np.ndarray:
        rows = []
        for run in runs:
            values = getattr(run, name)
            missing = length - values.shape[1]
            fill = np.zeros((values.shape[0], missing))
            rows.append(np.hstack([values, fill if rest else fill + values[:, -1:]]))
        return np.vstack(rows)

    moving = {name: join(name, True) for name in ("travel", "slip_x", "slip_y")}
    holding = {name: join(name, False) for name in ("fz", "alpha", "gamma", "pressure")}
    return RunInputs(
        **moving,
        **holding,
        start_fx=np.concatenate([r.start_fx for r in runs]),
        start_fy=np.concatenate([r.start_fy for r in runs]),
    )
