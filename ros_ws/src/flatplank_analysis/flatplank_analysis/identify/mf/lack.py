# SPDX-License-Identifier: Apache-2.0
"""Lack of fit: coefficients that are undetermined since the law misses the points, not for want of
a run.

The error of a coefficient contains all that the law leaves. Repeats of one setting show the
scatter alone. What would be determined with that scatter lacks no run: it lacks a law.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as variance_ratio

from ..results import Confusion
from .information import GRAIN, LEVEL, levels_of, listed
from .points import SteadyPoints

BY_LAW = "since the law is off"
SURELY = 0.01
"""probability with which repeats of a law that fits would show this lack of fit by chance [-]"""


@dataclass(frozen=True)
class Lack:
    """What the law leaves beyond the scatter of repeats."""

    axis: str
    """over which it leaves most"""
    levels: tuple[float, float]
    """between which it leaves most"""
    times: float
    """difference of what it leaves there, relative to the scatter of repeats [-]"""
    scatter: float
    """scatter of repeats, relative to that of all residuals [-]"""


def lack_of_fit(points: SteadyPoints, residual: np.ndarray, free: int) -> Lack | None:
    """Lack of fit of `free` coefficients with residuals (n,); None where repeats show none."""
    keys = np.column_stack([_level(points, axis) for axis in GRAIN])
    _, group, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    means = np.bincount(group, residual) / count
    within = float(np.sum((residual - means[group]) ** 2))
    repeats, spare = len(residual) - len(count), len(count) - free
    if min(repeats, spare) < 1 or not within > 0.0:
        return None
    pure = within / repeats
    beyond = float(np.sum(count * means**2)) / spare / pure
    if variance_ratio.sf(beyond, spare, repeats) > SURELY:
        return None
    axis = max(GRAIN, key=lambda name: _explained(points, name, residual))
    label, values = _level(points, axis), levels_of(points, axis)
    left = np.bincount(label, residual) / np.bincount(label)
    low, high = sorted((int(np.argmin(left)), int(np.argmax(left))))
    times = float(np.ptp(left)) / np.sqrt(pure)
    share = np.sqrt(pure / np.mean(residual**2))
    return Lack(axis, (float(values[low]), float(values[high])), times, float(share))


def restated(
    c: Confusion, lack: Lack, points: SteadyPoints,
    determined: Callable[[np.ndarray], set[str]],
) -> Confusion:  # fmt: skip
    """A statement with the law as the cause where its lack of fit is the cause.

    `determined(mask)`: the coefficients that the points of a mask (n,) would determine with the
    scatter of repeats.
    """
    names = set(c.names)
    if c.correlation < 1.0 or not names <= determined(np.ones(len(points), bool)):
        return c
    word, shown = LEVEL[lack.axis]
    label, values = _level(points, lack.axis), levels_of(points, lack.axis)
    alone = [shown(v) for k, v in enumerate(values) if names <= determined(label == k)]
    low, high = (shown(v) for v in lack.levels)
    verb = "is" if len(c.names) == 1 else "are"
    text = (
        f"{listed(c.names)} {verb} not determined {BY_LAW}: from {low} to {high} it is off by "
        f"{lack.times:.1f} times the scatter of repeats"
    )
    remedy = f"fit the runs of one {word} alone ({' or '.join(alone)})"
    return Confusion(c.names, 1.0, text, remedy if alone else "no run would: the law must change")


def _level(points: SteadyPoints, axis: str) -> np.ndarray:
    """Index of the level of every point (n,)."""
    middles = levels_of(points, axis)
    return np.argmin(np.abs(getattr(points, axis)[:, None] - middles), axis=1)


def _explained(points: SteadyPoints, axis: str, residual: np.ndarray) -> float:
    """Sum of squares that the levels of an axis explain, per level beyond the first."""
    label = _level(points, axis)
    count = np.bincount(label)
    if len(count) < 2:
        return 0.0
    means = np.bincount(label, residual) / count
    return float(np.sum(count * means**2)) / (len(count) - 1)
