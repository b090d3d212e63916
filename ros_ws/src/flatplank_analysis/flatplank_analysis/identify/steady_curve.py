# SPDX-License-Identifier: Apache-2.0
"""Steady force over slip of one condition (figure 7.7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..models.steady_law import TableLaw, table_law
from .linear import LinearFit
from .runs import StepRun, by_level


@dataclass(frozen=True)
class SteadyCurve:
    """F_ss over kappa: one point per slip level, repeats averaged."""

    kappa: np.ndarray
    """Mean actual slip per level (k,) [-]."""
    force: np.ndarray
    """Steady force per level (k,) [N]."""
    std_error: np.ndarray
    """Standard error per level (k,) [N]; NaN for a level without repeats."""
    repeats: np.ndarray
    """Number of runs per level (k,)."""

    def law(self) -> TableLaw:
        """As the look-up table of the model."""
        return table_law(self.kappa, self.force)

    def slope_weights(self) -> np.ndarray:
        """Weights (k,) [1] of the forces in C_Fkappa: difference of the levels next to zero."""
        low, high = np.flatnonzero(self.kappa < -2e-3), np.flatnonzero(self.kappa > 2e-3)
        i = low[-1] if len(low) else 0
        j = high[0] if len(high) else len(self.kappa) - 1
        weights = np.zeros(len(self.kappa))
        weights[[i, j]] = np.array([-1.0, 1.0]) / (self.kappa[j] - self.kappa[i])
        return weights


def steady_curve(runs: Sequence[StepRun], fits: Sequence[LinearFit]) -> SteadyCurve:
    """Mean asymptote of the linear fits per slip level."""
    place = {id(run): fit.steady_force.value for run, fit in zip(runs, fits, strict=True)}
    groups = list(by_level(runs).values())
    forces = [np.array([place[id(m)] for m in members]) for members in groups]
    return SteadyCurve(
        kappa=np.array([np.mean([m.kappa for m in members]) for members in groups]),
        force=np.array([f.mean() for f in forces]),
        std_error=np.array(
            [f.std(ddof=1) / np.sqrt(len(f)) if len(f) > 1 else np.nan for f in forces]
        ),
        repeats=np.array([len(f) for f in forces]),
    )
