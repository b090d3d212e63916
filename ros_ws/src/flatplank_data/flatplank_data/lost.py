# SPDX-License-Identifier: Apache-2.0
"""Samples that a run lacks: gaps between its stamps, and what its record counted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_data.table import MeasurementTable

REGULAR = 0.1
"""stamps of a clock are so near to whole periods apart [periods]"""
MOSTLY = 0.9
"""where fewer of them are, no clock is behind the samples and gaps cannot be told"""
MAX_ROAD = 0.02
"""no model is fitted across more road without a sample: a first-order response of 0.08 m
relaxation length would be off by 0.1 % [m]"""
MAX_SHARE = 0.1
"""no model is fitted to a run that lacks more: its noise is not that of the other runs"""


@dataclass(frozen=True)
class Lost:
    """What one run lacks."""

    lost: int
    of: int
    """samples that there should be"""
    longest: float = 0.0
    """without a sample at one stretch [s]"""
    road: float = 0.0
    """without a sample at one stretch [m]"""

    @property
    def share(self) -> float:
        return self.lost / self.of if self.of else 0.0

    @property
    def harmless(self) -> bool:
        """A fit can do without them."""
        return self.share <= MAX_SHARE and self.road <= MAX_ROAD

    def __str__(self) -> str:
        text = f"{self.lost} of {self.of} cycles lost ({100.0 * self.share:.2g} %)"
        if self.longest:
            text += f", up to {self.longest:.3g} s"
        if self.road:
            text += f" and {1e3 * self.road:.3g} mm of road"
        return text + (" at a stretch" if self.longest else "")


def lost_samples(table: MeasurementTable) -> Lost:
    """By the stamps or by the run's record, whichever has more."""
    found = _by_stamps(table)
    info = table.info
    if info.cycles_lost > found.lost:
        of = max(info.cycles_received + info.cycles_lost, len(table))
        return Lost(info.cycles_lost, of, found.longest, found.road)
    return found


def _by_stamps(table: MeasurementTable) -> Lost:
    none = Lost(0, len(table))
    if not table.has("time") or len(table) < 10:
        return none
    step = np.diff(table["time"])
    step = np.where(np.isfinite(step), step, 0.0)
    positive = step[step > 0.0]
    if not positive.size:
        return none
    # more than half may be lost: the shortest steps are the period
    rough = float(np.percentile(positive, 5))
    period = float(np.median(positive[positive < 1.5 * rough]))
    periods = np.rint(step / period)
    if np.mean(np.abs(step / period - periods) < REGULAR) < MOSTLY:
        return none
    gaps = periods > 1
    if not gaps.any():
        return none
    lost = int((periods[gaps] - 1).sum())
    road = 0.0
    if table.has("plank_position"):
        road = float(np.nanmax(np.abs(np.diff(table["plank_position"]))[gaps], initial=0.0))
    longest = float(step[gaps].max())
    return Lost(lost, len(table) + lost, longest, road if math.isfinite(road) else 0.0)
