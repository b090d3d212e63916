# SPDX-License-Identifier: Apache-2.0
"""Denoising of measured channels that are inputs of a model, and their values at rest.

The noise of an input biases every size towards zero, in all runs alike, and no repeat shows it.
So only what recurs in many runs is kept: the mean of the condition, the profile over the plank,
and the harmonics of the wheel angle. The rest counts as noise, except the level and the slow drift
of a load that was set by hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.grid import START, gaussian, quantum
from flatplank_data.table import MeasurementTable

ORDERS = (1, 2, 3)
"""harmonics of the wheel angle"""
SPACING, WIDTH = 0.006, 0.02
"""[m] spacing of the uniform grid, and width of the smoothing of a profile"""
RED = 4.0
"""largest ratio of the energies of slope and curvature in red noise; larger slopes are drift"""
STILL = 1e-5
"""[m] plank travel below which nothing moves: later a tire soon has tens of newtons"""
LEAST = 6
"""least number of filtered samples before the motion"""
STRAIGHT = np.radians(0.25)
"""[rad] largest angle of a wheel that counts as neither steered nor tilted"""
SURE = 5.0
"""standard errors above which a force at rest counts as real"""


@dataclass(frozen=True)
class Common:
    """Grouping of the runs for common profiles; arrays (runs, samples), lists of rows."""

    position: np.ndarray
    """plank travel [m]"""
    turn: np.ndarray
    """wheel angle in space [rad]"""
    grids: Sequence[np.ndarray]
    """groups of runs that share their nodes"""
    groups: Sequence[np.ndarray]
    """groups of runs of one condition"""

    def shape(self, values: np.ndarray) -> np.ndarray:
        """Denoised deviation of a channel from its mean (runs, samples): what runs share."""
        rest = values - values.mean(axis=1, keepdims=True)
        wheel = self._harmonics(rest)
        rest = rest - wheel
        profile, own = np.zeros_like(values), np.zeros_like(values)
        for rows in self.grids:
            profile[rows] = _shrunk_mean(np.stack([self._smooth(rows, r) for r in rest[rows]]))
        rest = rest - profile
        for rows in self.groups:
            own[rows] = _shrunk_mean(np.stack([self._smooth(rows, r) for r in rest[rows]]))
        return profile + wheel + own

    def level(self, values: np.ndarray) -> np.ndarray:
        """Mean of the condition (runs, 1)."""
        out = np.empty((len(values), 1))
        for rows in self.groups:
            out[rows] = values[rows].mean()
        return out

    def drift(self, values: np.ndarray) -> np.ndarray:
        """Mean and slope over the travel of each run, beyond the common shape (runs, samples).

        Red noise has slopes, too, up to twice as large as its curvature; smaller slopes are no
        drift.
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
        """The part that depends on the wheel angle, equal in all runs."""
        waves = [f(k * self.turn) for k in ORDERS for f in (np.cos, np.sin)]
        waves = np.stack([w - w.mean(axis=1, keepdims=True) for w in waves])
        flat = waves.reshape(len(waves), -1)
        size = np.linalg.lstsq(flat.T, rest.reshape(-1), rcond=1e-6)[0]
        return (size @ flat).reshape(rest.shape)


def _shrunk_mean(each: np.ndarray) -> np.ndarray:
    """Mean of several curves (k, samples), shrunk towards zero by the noise they contain."""
    k, mean = len(each), each.mean(axis=0)
    if k < 2:
        return np.zeros_like(mean)
    noise = float(np.sum((each - mean) ** 2)) / (k * (k - 1))
    return mean * max(0.0, 1.0 - noise / max(float(np.sum(mean**2)), 1e-30))


def as_load(values: np.ndarray, common: Common) -> np.ndarray:
    """Denoise a load that was set by hand: the common part, and each run's own level and drift."""
    shape = common.shape(values)
    return shape + common.drift(values - shape)


def as_input(values: np.ndarray, common: Common) -> np.ndarray:
    """Denoise a channel with possible crosstalk into another one: the common part only."""
    return common.level(values) + common.shape(values)


def at_rest(
    smooth: Sequence[Mapping[str, np.ndarray]], names: Sequence[str], settings: np.ndarray
) -> tuple[float, ...]:
    """Standard deviation of the filtered channels before the motion, within a run and from run to
    run; empty: no run has a rest.

    settings (runs, k): what a standing wheel depends on. The slip is none of it: runs of other
    slip are repeats as long as they stand, and only they show noise that is slower than a rest.
    """
    within, levels, kinds = [], [], []
    for columns, setting in zip(smooth, settings, strict=True):
        moved = np.flatnonzero(columns["plank_position"] > STILL)
        # repeated first values are padding, not measurements
        held = np.all([np.diff(columns[n], prepend=np.nan) == 0.0 for n in names], axis=0)
        rows = np.flatnonzero(~held[: moved[0] if len(moved) else 0])
        if len(rows) < LEAST:
            continue
        within.append([np.var(columns[n][rows], ddof=1) for n in names])
        levels.append([np.mean(columns[n][rows]) for n in names])
        kinds.append(setting)
    if not within:
        return ()
    _, kind = np.unique(np.array(kinds), axis=0, return_inverse=True)
    apart = np.array(levels)
    for k in np.unique(kind):
        apart[kind == k] -= apart[kind == k].mean(axis=0)
    spare = max(len(kind) - len(np.unique(kind)), 1)
    square = np.mean(within, axis=0) + np.sum(apart**2, axis=0) / spare
    return tuple(float(v) for v in np.sqrt(square))


def steps_of(tables: Sequence[MeasurementTable], names: Sequence[str]) -> tuple[float, ...]:
    """Resolution of each channel, 0 where its values have no common step."""
    return tuple(max(quantum(t[n][np.isfinite(t[n])]) for t in tables[:3]) for n in names)


def side_force(
    fy: np.ndarray | None, position: np.ndarray, facts: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Fy of the standing wheel (runs,) [N]: mean over all runs of a setting, minus the zero of the
    channel from straight wheels; 0 where it is within the noise.

    fy [N] and position [m] (runs, samples), fy None where it was not recorded; facts (runs,):
    alpha and gamma [rad], nominal load [N].
    """
    out = np.zeros(len(position))
    if fy is None:
        return out
    standing = position < position[:, :1] + START
    level = np.where(standing, fy, 0.0).sum(axis=1) / standing.sum(axis=1)
    settings = np.stack([facts["alpha"], facts["gamma"], facts["nominal"]], axis=1)
    straight = np.abs(settings[:, :2]).max(axis=1) < STRAIGHT
    level = level - (level[straight].mean() if straight.any() else 0.0)
    for setting in np.unique(settings[~straight], axis=0):
        rows = np.flatnonzero((settings == setting).all(axis=1))
        mean = float(level[rows].mean())
        if len(rows) > 1 and abs(mean) > SURE * level[rows].std(ddof=1) / np.sqrt(len(rows)):
            out[rows] = mean
    return out
