# SPDX-License-Identifier: Apache-2.0
"""A measured channel without its noise, as an input of a model.

The noise of an input makes every size too small, in all runs alike, and no repeat shows it.
What a channel does in the same way in many runs is kept: the mean of its
condition, the profile over the plank, what goes with the wheel angle. What only one run shows is
taken for noise, but for the level and the slow drift of a load that was set by hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.grid import gaussian

ORDERS = (1, 2, 3)
"""of the wheel angle"""
SPACING, WIDTH = 0.006, 0.02
"""[m] even grid, and width over which a course is smoothed"""
RED = 4.0
"""energy of the slopes of red noise over that of its bends, at most"""


@dataclass(frozen=True)
class Common:
    """What runs have in common; arrays (runs, samples), lists of rows."""

    position: np.ndarray
    """plank travel [m]"""
    turn: np.ndarray
    """wheel angle in space [rad]"""
    grids: Sequence[np.ndarray]
    """runs that share their nodes"""
    groups: Sequence[np.ndarray]
    """runs of a condition"""

    def shape(self, values: np.ndarray) -> np.ndarray:
        """Course of a channel (runs, samples) about its mean, without what only one run shows."""
        rest = values - values.mean(axis=1, keepdims=True)
        wheel = self._harmonics(rest)
        rest = rest - wheel
        profile, own = np.zeros_like(values), np.zeros_like(values)
        for rows in self.grids:
            profile[rows] = _trusted(np.stack([self._smooth(rows, r) for r in rest[rows]]))
        rest = rest - profile
        for rows in self.groups:
            own[rows] = _trusted(np.stack([self._smooth(rows, r) for r in rest[rows]]))
        return profile + wheel + own

    def level(self, values: np.ndarray) -> np.ndarray:
        """Mean of the condition (runs, 1)."""
        out = np.empty((len(values), 1))
        for rows in self.groups:
            out[rows] = values[rows].mean()
        return out

    def drift(self, values: np.ndarray) -> np.ndarray:
        """Mean and slope over the travel that each run has beside the shape (runs, samples).

        Red noise has slopes, too, up to twice as large as its bends: slopes that are not larger
        than that are no drift.
        """
        along = self.position - self.position.mean(axis=1, keepdims=True)
        along = along / np.sqrt(np.mean(along**2, axis=1, keepdims=True))
        bend = along**2 - 1.0
        bend = bend - along * np.mean(along * bend, axis=1, keepdims=True)
        bend = bend / np.sqrt(np.mean(bend**2, axis=1, keepdims=True))
        slope, bent = np.mean(along * values, axis=1), np.mean(bend * values, axis=1)
        noise = (RED * np.mean(bent**2)) / max(float(np.mean(slope**2)), 1e-30)
        return values.mean(axis=1, keepdims=True) + max(0.0, 1.0 - noise) * slope[:, None] * along

    def _smooth(self, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
        position = self.position[rows].mean(axis=0)
        even = np.arange(position[0], position[-1] + SPACING, SPACING)
        smoothed = gaussian(np.interp(even, position, values), WIDTH / SPACING)
        return np.interp(position, even, smoothed)

    def _harmonics(self, rest: np.ndarray) -> np.ndarray:
        """The part that goes with the wheel angle, alike in all runs."""
        waves = [f(k * self.turn) for k in ORDERS for f in (np.cos, np.sin)]
        waves = np.stack([w - w.mean(axis=1, keepdims=True) for w in waves])
        flat = waves.reshape(len(waves), -1)
        size = np.linalg.lstsq(flat.T, rest.reshape(-1), rcond=1e-6)[0]
        return (size @ flat).reshape(rest.shape)


def _trusted(each: np.ndarray) -> np.ndarray:
    """Mean of several courses (k, samples), drawn to zero as far as it may be their noise."""
    k, mean = len(each), each.mean(axis=0)
    if k < 2:
        return np.zeros_like(mean)
    noise = float(np.sum((each - mean) ** 2)) / (k * (k - 1))
    return mean * max(0.0, 1.0 - noise / max(float(np.sum(mean**2)), 1e-30))


def as_load(values: np.ndarray, common: Common) -> np.ndarray:
    """A load that was set by hand: what is common, and each run's own level and drift."""
    shape = common.shape(values)
    return shape + common.drift(values - shape)


def as_input(values: np.ndarray, common: Common) -> np.ndarray:
    """A channel that may speak over into another one: what is common only."""
    return common.level(values) + common.shape(values)
