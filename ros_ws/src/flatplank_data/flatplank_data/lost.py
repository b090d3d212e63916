# SPDX-License-Identifier: Apache-2.0
"""Counts lost samples of a run, by gaps between its stamps or by the count in its record."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_data.table import MeasurementTable

REGULAR = 0.1
"""largest distance of a time step from a whole number of periods [periods]"""
MOSTLY = 0.9
"""smallest share of such steps; below it sampling is irregular and gaps cannot be found [-]"""
MAX_ROAD = 0.02
"""longest road without a sample in a run to be fitted [m]: such a gap changes a first-order
response of 0.08 m relaxation length by 0.1 %"""
MAX_SHARE = 0.1
"""largest share of lost samples in a run to be fitted [-]: with more, its noise differs from that
of other runs"""


@dataclass(frozen=True)
class LostSamples:
    """Lost samples of one run."""

    lost: int
    of: int
    """expected number of samples"""
    longest: float = 0.0
    """longest time without a sample [s]"""
    road: float = 0.0
    """longest road without a sample [m]"""

    @property
    def share(self) -> float:
        return self.lost / self.of if self.of else 0.0

    @property
    def allows_fit(self) -> bool:
        """True when a model can be fitted to the samples that are left."""
        return self.share <= MAX_SHARE and self.road <= MAX_ROAD

    def __str__(self) -> str:
        text = f"{self.lost} of {self.of} cycles lost ({100.0 * self.share:.2g} %)"
        if self.longest:
            text += f", up to {self.longest:.3g} s"
        if self.road:
            text += f" and {1e3 * self.road:.3g} mm of road"
        return text + (" at a stretch" if self.longest else "")


def lost_samples(table: MeasurementTable) -> LostSamples:
    """Lost samples by the stamps or by the run record, whichever counts more."""
    found = _by_stamps(table)
    info = table.info
    if info.cycles_lost > found.lost:
        of = max(info.cycles_received + info.cycles_lost, len(table))
        return LostSamples(info.cycles_lost, of, found.longest, found.road)
    return found


def _by_stamps(table: MeasurementTable) -> LostSamples:
    none = LostSamples(0, len(table))
    if not table.has("time") or len(table) < 10:
        return none
    step = np.diff(table["time"])
    step = np.where(np.isfinite(step), step, 0.0)
    positive = step[step > 0.0]
    if not positive.size:
        return none
    # more than half of the samples may be lost: take the period from the shortest steps
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
    return LostSamples(lost, len(table) + lost, longest, road if math.isfinite(road) else 0.0)
