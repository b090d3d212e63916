# SPDX-License-Identifier: Apache-2.0
"""Divides a recording into conditions: a swept slip, and levels of the other quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from flatplank_analysis.slip_sweeps.channels import SWEEPS
from flatplank_data.wording import plain

SMOOTH = 25
"""samples of the running median against noise and ripple of the load"""
LEAST_SHARE = 0.01
"""least share of all samples at a level; fewer are a transition between levels"""


class HeldChannel(NamedTuple):
    """A channel that is held at levels, and the least distance of two levels."""

    name: str
    title: str
    apart: float
    """share of the largest value, or [SI] where `absolute`"""
    absolute: bool
    scale: float
    """factor from SI to the display unit"""
    unit: str

    def word(self, value: float) -> str:
        """A level [SI] as text: '1200 N'."""
        return f"{plain(round(self.scale * value, 6) + 0.0)} {self.unit}"

    def distance(self, values: np.ndarray) -> float:
        """Least distance of two levels of these values [SI]."""
        return self.apart if self.absolute else self.apart * float(np.abs(values).max() or 1.0)

    def several(self, values: Sequence[float]) -> bool:
        """Whether these values are more than one level."""
        return len(values) > 1 and float(np.ptp(values)) > self.distance(np.array(values))


HELD = (
    HeldChannel("fz", "load", 0.08, False, 1.0, "N"),
    HeldChannel("gamma", "camber", np.radians(0.5), True, 180.0 / np.pi, "deg"),
    HeldChannel("pressure", "pressure", 0.05, False, 1e-3, "kPa"),
    HeldChannel("speed", "speed", 0.1, False, 3.6, "km/h"),
    HeldChannel("alpha", "slip angle", np.radians(0.5), True, 180.0 / np.pi, "deg"),
    HeldChannel("kappa", "slip", 0.02, True, 100.0, "%"),
)
BY_NAME = {held.name: held for held in HELD}


def not_held(columns: Mapping[str, np.ndarray]) -> HeldChannel | None:
    """A channel that changes its level from row to row: the rows are not in order of time."""
    for held in HELD[:4]:
        if held.name in columns:
            values = columns[held.name]
            smooth = median_filter(values, min(SMOOTH, len(values)), mode="nearest")
            if (np.abs(values - smooth) > held.distance(smooth)).mean() > 0.5:
                return held
    return None


def levels(held: HeldChannel, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of the levels (n,), and the level of each sample; -1 between two levels."""
    smooth = median_filter(values, min(SMOOTH, len(values)), mode="nearest")
    apart = held.distance(smooth)
    order = np.sort(smooth)
    edges = _valleys(order, apart)
    number = np.searchsorted(edges, smooth)
    centers: list[float] = []
    names = np.full(len(values), -1)
    for k in np.unique(number):
        inside = number == k
        if inside.sum() < max(LEAST_SHARE * len(values), SMOOTH):
            continue
        center = float(np.median(smooth[inside]))
        near = inside & (np.abs(smooth - center) < apart)
        if near.sum() >= max(LEAST_SHARE * len(values), SMOOTH):
            names[near] = len(centers)
            centers.append(center)
    return np.array(centers), names


def _valleys(order: np.ndarray, apart: float) -> np.ndarray:
    """Values between levels: centres of gaps in a histogram with bins of a quarter of `apart`."""
    low, high = order[0], order[-1]
    bins = int(np.clip(np.ceil(4.0 * (high - low) / apart), 1, 4000))
    count, edges = np.histogram(order, bins=bins, range=(low, high if high > low else low + 1.0))
    filled = count >= max(LEAST_SHARE / 8.0 * len(order), 1.0)
    # a valley is an empty range between filled bins; its middle separates the levels
    starts = np.flatnonzero(filled[:-1] & ~filled[1:]) + 1
    out = []
    for start in starts:
        after = np.flatnonzero(filled[start:])
        if len(after):
            out.append(0.5 * (edges[start] + edges[start + after[0]]))
    return np.array(out)


WIDE = dict(SWEEPS.values())
"""least range of a swept slip [rad, -]"""
FORCE = {slip: force for force, (slip, _) in SWEEPS.items()}
"""swept slip -> force that is evaluated"""
UNLOADED = 0.05
"""share of the largest load below which the tire is unloaded"""
BINS = 30
"""number of bins over the range of the swept slip"""
LEAST = 60
"""least number of samples of a condition"""


@dataclass(frozen=True)
class SweepCondition:
    """One combination of levels, and the samples that belong to it."""

    swept: str
    """alpha or kappa"""
    held: Mapping[str, float]
    """levels by channel [SI]"""
    samples: np.ndarray
    """indices of its samples, in time order"""
    visits: int
    """number of separate times at which the condition was measured"""
    stated: frozenset[str] = frozenset()
    """channels whose level differs between the conditions"""

    @property
    def label(self) -> str:
        """The condition as text: 'slip angle swept, 1100 N, camber 4 deg'."""
        words = {"gamma": "camber ", "alpha": "slip angle ", "kappa": "slip "}
        levels = (words.get(h.name, "") + h.word(self.held[h.name]) for h in self.levels())
        return ", ".join([f"{self.slip.title} swept", *levels])

    @property
    def slip(self) -> HeldChannel:
        """The swept slip."""
        return BY_NAME[self.swept]

    def levels(self) -> list[HeldChannel]:
        """Channels that are held here and differ between the conditions."""
        return [h for h in HELD if h.name in self.held and h.name in self.stated]


def split_into_conditions(columns: Mapping[str, np.ndarray]) -> list[SweepCondition]:
    """Conditions in the order in which they were first measured; columns in ISO W, SI."""
    loaded = columns["fz"] > UNLOADED * columns["fz"].max()
    swept = _swept(columns, loaded)
    found = []
    for slip, rows in swept.items():
        if FORCE[slip] in columns:
            measured = np.isfinite(columns[FORCE[slip]][rows])
            found += _by_levels(columns, slip, rows[measured])
    stated = frozenset(held.name for held in HELD if _differs(held, found))
    return sorted((replace(c, stated=stated) for c in found), key=lambda c: c.samples[0])


def _differs(held: HeldChannel, conditions: Sequence[SweepCondition]) -> bool:
    """Whether a channel was held at several levels, or only in some of the conditions."""
    levels = [c.held[held.name] for c in conditions if held.name in c.held]
    return 0 < len(levels) < len(conditions) or held.several(levels)


def _swept(columns: Mapping[str, np.ndarray], loaded: np.ndarray) -> dict[str, np.ndarray]:
    """Swept slip -> its loaded samples, at which it varies more than the other slip."""
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


def _by_levels(columns, slip: str, rows: np.ndarray) -> list[SweepCondition]:
    if len(rows) < LEAST:
        return []
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
        found.append(SweepCondition(slip, at, mine, _visits(mine)))
    return found


def _visits(samples: np.ndarray) -> int:
    """Number of times at which the condition was measured, separated by long gaps."""
    return 1 + int((np.diff(samples) > max(len(samples) // 2, LEAST)).sum())
