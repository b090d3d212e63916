# SPDX-License-Identifier: Apache-2.0
"""Levels at which a channel was held while another one was swept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from flatplank_data.wording import plain

SMOOTH = 25
"""samples of the running median that takes noise and ripple of the load off"""
LEAST_SHARE = 0.01
"""of all samples; fewer are a passage from one level to the next"""


class Held(NamedTuple):
    """A channel that is held, and how far apart two levels are at least."""

    name: str
    apart: float
    """share of the largest value, or [SI] where `absolute`"""
    absolute: bool
    scale: float
    """from SI to what people read"""
    unit: str

    def word(self, value: float) -> str:
        """A level [SI] for people: '1200 N'."""
        return f"{plain(round(self.scale * value, 6) + 0.0)} {self.unit}"

    def distance(self, values: np.ndarray) -> float:
        """How far apart two levels of these values are at least [SI]."""
        return self.apart if self.absolute else self.apart * float(np.abs(values).max() or 1.0)

    def several(self, values: Sequence[float]) -> bool:
        """Whether these values are more than one level."""
        return len(values) > 1 and float(np.ptp(values)) > self.distance(np.array(values))


HELD = (
    Held("fz", 0.08, False, 1.0, "N"),
    Held("gamma", np.radians(0.5), True, 180.0 / np.pi, "deg"),
    Held("pressure", 0.05, False, 1e-3, "kPa"),
    Held("speed", 0.1, False, 3.6, "km/h"),
    Held("alpha", np.radians(0.5), True, 180.0 / np.pi, "deg"),
    Held("kappa", 0.02, True, 100.0, "%"),
)


def levels(held: Held, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of the levels (n,), and the level of each sample; -1 where it is between two."""
    smooth = median_filter(values, min(SMOOTH, len(values)), mode="nearest")
    apart = held.distance(smooth)
    order = np.sort(smooth)
    edges = _valleys(order, apart)
    number = np.searchsorted(edges, smooth)
    centers: list[float] = []
    names = np.full(len(values), -1)
    for k in range(len(edges) + 1):
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
    """Between which values hardly any sample lies, over a width of `apart`."""
    low, high = order[0], order[-1]
    bins = int(np.clip(np.ceil(4.0 * (high - low) / apart), 1, 4000))
    count, edges = np.histogram(order, bins=bins, range=(low, high if high > low else low + 1.0))
    filled = count >= max(LEAST_SHARE / 8.0 * len(order), 1.0)
    # a valley is an empty bin between filled ones; its middle divides the levels
    starts = np.flatnonzero(filled[:-1] & ~filled[1:]) + 1
    out = []
    for start in starts:
        after = np.flatnonzero(filled[start:])
        if len(after):
            out.append(0.5 * (edges[start] + edges[start + after[0]]))
    return np.array(out)
