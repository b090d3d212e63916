# SPDX-License-Identifier: Apache-2.0
"""Steady force over slip of one condition (figure 7.7), and what each run brings to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..models.steady_law import TableLaw, table_law
from .linear import LinearFit
from .runs import StepRun, by_level


@dataclass(frozen=True)
class SteadyCurve:
    """F_ss over kappa of one condition (figure 7.7) from the runs' linear fits."""

    kappa: np.ndarray
    """Mean actual slip per level (k,) [-]."""
    force: np.ndarray
    """Mean asymptote per level (k,) [N]."""
    influence: np.ndarray = field(repr=False)
    """What each run brings to each level's mean (runs, k) [N]; its square sum is the variance."""
    repeats: np.ndarray = field(repr=False)
    """Number of runs per level (k,)."""

    def law(self) -> TableLaw:
        """As the look-up table of the model."""
        return table_law(self.kappa, self.force)

    @property
    def std_error(self) -> np.ndarray:
        """Standard error of each level from its repeats (k,) [N]; NaN for a single run."""
        n = self.repeats
        spread = np.sqrt(np.sum(self.influence**2, axis=0) * n / np.maximum(n - 1, 1))
        return np.where(n > 1, spread, np.nan)


def steady_curve(runs: Sequence[StepRun], fits: Sequence[LinearFit]) -> SteadyCurve:
    """Mean asymptote per slip level; repeats are averaged."""
    levels = by_level(runs)
    place = {id(run): i for i, run in enumerate(runs)}
    influence = np.zeros((len(runs), len(levels)))
    kappa, force, repeats = [], [], []
    for column, members in enumerate(levels.values()):
        index = [place[id(m)] for m in members]
        asymptotes = np.array([fits[i].steady_force.value for i in index])
        kappa.append(np.mean([m.kappa for m in members]))
        force.append(asymptotes.mean())
        repeats.append(len(members))
        influence[index, column] = (asymptotes - asymptotes.mean()) / len(members)
    return SteadyCurve(np.array(kappa), np.array(force), influence, np.array(repeats))


def slope_at_zero(curve: SteadyCurve) -> tuple[float, np.ndarray]:
    """C_Fkappa [N] from the levels next to zero on both sides, and each run's part in it."""
    low = np.flatnonzero(curve.kappa < -2e-3)
    high = np.flatnonzero(curve.kappa > 2e-3)
    i = low[-1] if len(low) else 0
    j = high[0] if len(high) else len(curve.kappa) - 1
    span = curve.kappa[j] - curve.kappa[i]
    slope = (curve.force[j] - curve.force[i]) / span
    return float(slope), (curve.influence[:, j] - curve.influence[:, i]) / span
