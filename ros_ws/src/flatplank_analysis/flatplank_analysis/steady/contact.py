# SPDX-License-Identifier: Apache-2.0
"""Contact length from a table of footprints (Appendix G.1) by (7.20)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ContactLength:
    """a = r_0 (q_ra2 F_z/(C_z r_0) + q_ra1 sqrt(F_z/(C_z r_0))) (7.20)."""

    q_ra1: float
    q_ra2: float
    radius: float
    """r_0 [m]"""
    rmse: float
    """[m]"""
    both: bool = True
    """False: one load cannot tell q_ra1 and q_ra2 apart, q_ra2 is held at 0"""

    def half_length(self, fz: np.ndarray | float, stiffness: np.ndarray | float) -> np.ndarray:
        """a [m] at load [N] and vertical stiffness [N/m]."""
        deflection = np.asarray(fz) / (np.asarray(stiffness) * self.radius)
        return self.radius * (self.q_ra2 * deflection + self.q_ra1 * np.sqrt(deflection))


def fit_contact_length(
    fz: np.ndarray, half_length: np.ndarray, stiffness: np.ndarray, radius: float
) -> ContactLength:
    """Linear least squares for q_ra1, q_ra2; arrays of shape (footprints,), SI.

    With one footprint only, q_ra2 is 0: a single load cannot tell the two apart.
    """
    deflection = np.asarray(fz, float) / (np.asarray(stiffness, float) * radius)
    basis = radius * np.column_stack([np.sqrt(deflection), deflection])
    half_length = np.asarray(half_length, float)
    if np.unique(np.round(deflection, 6)).size < 2:
        basis = basis[:, :1]
    found, *_ = np.linalg.lstsq(basis, half_length, rcond=None)
    error = float(np.sqrt(np.mean((basis @ found - half_length) ** 2)))
    q_ra2 = float(found[1]) if found.size > 1 else 0.0
    return ContactLength(float(found[0]), q_ra2, radius, error, found.size > 1)


def friction(steady_forces: np.ndarray, loads: np.ndarray) -> float:
    """mu: mean over conditions of |F_x,ss| at |kappa| = 10 % over F_z (section 7.2)."""
    ratio = np.abs(np.asarray(steady_forces, float)) / np.asarray(loads, float)
    ratio = ratio[np.isfinite(ratio)]
    return float(ratio.mean()) if ratio.size else math.nan
