# SPDX-License-Identifier: Apache-2.0
"""Contact length over load and pressure (7.20)-(7.22), and the patch's own relaxation length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LOWEST_SHARE = 0.01
"""Lower limit of the adhering part m of the contact (section 7.2)."""


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
    q_ra2: float = 0.120

    def stiffness(self, pressure: np.ndarray | float) -> np.ndarray:
        """C_z [N/m] (7.21) at pressure [Pa]."""
        change = (np.asarray(pressure, float) - self.nominal_pressure) / self.nominal_pressure
        return self.vertical_stiffness * (1.0 + self.pressure_effect * change)

    def half_length(self, fz: np.ndarray | float, pressure: np.ndarray | float) -> np.ndarray:
        """Half contact length a [m] (7.20)."""
        rho = np.asarray(fz, float) / (self.stiffness(pressure) * self.free_radius)
        return self.free_radius * (self.q_ra2 * rho + self.q_ra1 * np.sqrt(rho))


TOYO = ContactGeometry()
"""Only for studies on the simulated Toyo: a campaign's tire comes from its record."""


def patch_relaxation(
    slip: np.ndarray, theta: np.ndarray, a: np.ndarray, longitudinal: bool = True
) -> np.ndarray:
    """sigma_c [m] (7.17), (7.18) at contact-patch slip kappa' (or tan alpha' in y).

    The adhering share shrinks with slip; theta [-] of (7.19), half contact length a [m].
    """
    base = np.maximum(1.0 + slip, 0.1) if longitudinal else 1.0
    return np.maximum(1.0 - theta * np.abs(slip) / base, LOWEST_SHARE) * a / base
