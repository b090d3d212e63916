# SPDX-License-Identifier: Apache-2.0
"""A recording cut into conditions: what was swept, and at which levels the rest was held."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from flatplank_analysis.slip_sweeps.levels import HELD, SMOOTH, Held, levels

WIDE = {"alpha": np.radians(2.0), "kappa": 0.04}
"""a slip that ranges over less is held [rad, -]"""
FORCE = {"alpha": "fy", "kappa": "fx"}
"""force that a sweep is made for"""
UNLOADED = 0.05
"""share of the largest load below which the tire is in the air"""
BINS = 30
"""of the range of the swept slip"""
LEAST = 60
"""samples of a condition"""


@dataclass(frozen=True)
class Condition:
    """One combination of levels, and the samples that belong to it."""

    swept: str
    """alpha or kappa"""
    held: Mapping[str, float]
    """levels by channel [SI]"""
    samples: np.ndarray
    """their numbers, in time"""
    visits: int
    """how often it was come back to"""
    told: frozenset[str] = frozenset()
    """channels whose level differs between the conditions"""

    @property
    def label(self) -> str:
        """For people: 'slip angle swept, 1100 N, camber 4 deg'."""
        what = {"alpha": "slip angle", "kappa": "slip"}[self.swept]
        return ", ".join([f"{what} swept", *self._levels()])

    def _levels(self) -> Iterator[str]:
        words = {"gamma": "camber ", "alpha": "slip angle ", "kappa": "slip "}
        for held in HELD:
            if held.name in self.held and held.name in self.told:
                yield words.get(held.name, "") + held.word(self.held[held.name])


def cut(columns: Mapping[str, np.ndarray]) -> list[Condition]:
    """Conditions in the order in which they were first measured; columns in ISO W, SI."""
    loaded = columns["fz"] > UNLOADED * columns["fz"].max()
    swept = _swept(columns, loaded)
    found = []
    for slip, rows in swept.items():
        if FORCE[slip] in columns:
            found += _by_levels(columns, slip, rows)
    told = frozenset(held.name for held in HELD if _differs(held, found))
    return sorted((replace(c, told=told) for c in found), key=lambda c: c.samples[0])


def _differs(held: Held, conditions: Sequence[Condition]) -> bool:
    """Whether a channel was held at several levels, or only in some of the conditions."""
    levels = [c.held[held.name] for c in conditions if held.name in c.held]
    return 0 < len(levels) < len(conditions) or held.several(levels)


def _swept(columns: Mapping[str, np.ndarray], loaded: np.ndarray) -> dict[str, np.ndarray]:
    """Which slip is swept in which samples: the one that moves, while the other one stands."""
    n = len(loaded)
    window = max(n // 200, 4 * SMOOTH)
    moving = {}
    for slip, wide in WIDE.items():
        if slip not in columns:
            continue
        smooth = median_filter(columns[slip], min(SMOOTH, n), mode="nearest")
        pieces = np.array_split(np.arange(n), max(n // window, 1))
        span = np.concatenate([np.full(len(p), np.ptp(smooth[p])) for p in pieces])
        total = np.ptp(smooth)
        moving[slip] = span / wide if total > wide else np.zeros(n)
    out = {}
    for slip, how in moving.items():
        others = [m for name, m in moving.items() if name != slip]
        most = np.all([how >= m for m in others], axis=0) if others else np.ones(n, bool)
        rows = np.flatnonzero(loaded & most & (how > 0.0))
        if len(rows) >= LEAST:
            out[slip] = rows
    return out


def _by_levels(columns, slip: str, rows: np.ndarray) -> list[Condition]:
    names, values = [], []
    key = np.zeros(len(rows), int)
    good = np.ones(len(rows), bool)
    for held in HELD:
        if held.name == slip or held.name not in columns:
            continue
        centers, number = levels(held, columns[held.name][rows])
        if not len(centers):
            continue
        good &= number >= 0
        key = key * len(centers) + np.maximum(number, 0)
        names.append(held.name)
        values.append(centers)
    found = []
    for code in np.unique(key[good]):
        mine = rows[good & (key == code)]
        if len(mine) < LEAST or np.ptp(columns[slip][mine]) < WIDE[slip]:
            continue
        at: dict[str, float] = {}
        rest = int(code)
        for name, centers in zip(reversed(names), reversed(values), strict=True):
            rest, k = divmod(rest, len(centers))
            at[name] = float(centers[k])
        found.append(Condition(slip, at, mine, _visits(mine)))
    return found


def _visits(samples: np.ndarray) -> int:
    """How often the condition was left for long and come back to."""
    return 1 + int((np.diff(samples) > max(len(samples) // 2, LEAST)).sum())
