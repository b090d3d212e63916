# SPDX-License-Identifier: Apache-2.0
"""Steady-state force over slip of the contact patch: the table of chapter 7, or a smooth law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.interpolate import PchipInterpolator

from flatplank_data.errors import FlatplankError

CELLS = 2000
"""Cells of the even table that a measured curve is turned into."""


class SteadyLaw(Protocol):
    """Force over contact-patch slip for several runs at once."""

    def force(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and its slope [N] at slip (lanes, runs)."""
        ...

    def stiffness(self) -> np.ndarray:
        """Slope at zero slip [N], broadcasting to (lanes, runs)."""
        ...

    def table(self) -> TableLaw | None:
        """The law as an even table, if it is one."""
        ...


@dataclass(frozen=True)
class TableLaw:
    """Look-up table F_ss(kappa) per run (7.14), fine even nodes, straight beyond.

    `values` (runs or 1, nodes) or (lanes, runs or 1, nodes) [N] on even slips `first` + i `step`.
    """

    first: float
    step: float
    values: np.ndarray

    def force(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and slope [N] at slip (lanes, runs)."""
        place = (slip - self.first) / self.step
        last = self.values.shape[-1] - 2
        cell = np.minimum(np.maximum(place, 0.0), last).astype(np.intp)
        low, high = self._take(cell), self._take(cell + 1)
        rise = high - low
        return low + (place - cell) * rise, rise / self.step

    def stiffness(self) -> np.ndarray:
        """Slope at zero slip over +-0.5 % [N]."""
        values = self.values if self.values.ndim == 3 else self.values[None]
        span = np.full(values.shape[:2], 0.005)
        return (self.force(span)[0] - self.force(-span)[0]) / 0.01

    def table(self) -> TableLaw:
        """The law itself."""
        return self

    def _take(self, cell: np.ndarray) -> np.ndarray:
        values = self.values
        if values.ndim == 2:
            return values[np.arange(values.shape[0]), cell]
        lanes, runs = values.shape[:2]
        return values[np.arange(lanes)[:, None], np.arange(runs), cell]


def table_law(slip: np.ndarray, force: np.ndarray) -> TableLaw:
    """Table through measured steady forces (figure 7.7).

    Between the points a monotone cubic (no kinks that a search would stumble over, no overshoot).
    `slip` (k,) increasing, `force` (k,) or (lanes, k) [N].
    """
    slip = np.asarray(slip, float)
    force = np.atleast_2d(np.asarray(force, float))
    if len(slip) < 2 or np.any(np.diff(slip) <= 0.0):
        raise FlatplankError(
            "steady-state curve needs two or more increasing slips", "", "measure more slips"
        )
    reach = slip[-1] - slip[0]
    first, step = slip[0], reach / CELLS
    even = first + step * np.arange(CELLS + 1)
    values = PchipInterpolator(slip, force, axis=1)(even)
    return TableLaw(float(first), float(step), values[:, None, :] if len(values) > 1 else values)


@dataclass(frozen=True)
class SineLaw:
    """F = D sin(C atan(B slip)) + offset: a smooth law with one stiffness and one peak.

    All (lanes, 1) or (lanes, runs): stiffness B C D [N], peak D [N], shape C [-], offset [N].
    """

    slope: np.ndarray
    peak: np.ndarray
    shape: np.ndarray
    offset: np.ndarray

    def force(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and slope [N] at slip (lanes, runs)."""
        b = self.slope / (self.shape * self.peak)
        angle = self.shape * np.arctan(b * slip)
        slope = self.slope * np.cos(angle) / (1.0 + (b * slip) ** 2)
        return self.peak * np.sin(angle) + self.offset, slope

    def stiffness(self) -> np.ndarray:
        """Slope at zero slip [N]."""
        return np.asarray(self.slope, float)

    def table(self) -> None:
        """A formula is no table."""
        return None
