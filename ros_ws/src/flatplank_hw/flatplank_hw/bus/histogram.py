# SPDX-License-Identifier: Apache-2.0
"""Histograms of durations in constant memory, for runs of any length."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any


def percentile(counts: Sequence[int], share: float) -> int:
    """Index of the lowest bin that, together with all lower bins, holds `share` of all counts; 0
    without counts."""
    wanted, seen = share * sum(counts), 0
    for place, count in enumerate(counts):
        seen += count
        if count and seen >= wanted:
            return place
    return 0


FIRST_US = 10.0
"""upper edge of the first bin [us]"""
GROWTH = 1.1
"""upper edge of a bin over that of the bin before [-]"""
BINS = 160
_LOG = math.log(GROWTH)
SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "p99.99": 0.9999, "worst": 1.0}
"""percentiles for people"""
KEYS = {label: f"{label.replace('.', '_')}_us" for label in SHARES}
"""label -> key in a report"""


class Histogram:
    """Histogram of durations with bins of equal width in the logarithm."""

    def __init__(self) -> None:
        self.counts = [0] * BINS
        self.total = 0
        self.largest_ns = 0

    def add(self, duration_ns: int) -> None:
        """Count one duration."""
        self.total += 1
        if duration_ns > self.largest_ns:
            self.largest_ns = duration_ns
        ratio = duration_ns / (FIRST_US * 1e3)
        place = 0 if ratio <= 1.0 else min(int(math.log(ratio) / _LOG) + 1, BINS - 1)
        self.counts[place] += 1

    def percentile_us(self, share: float) -> float:
        """Percentile as the upper edge of its bin, at most the largest duration counted [us]; of
        all durations the largest."""
        if share >= 1.0:
            return self.largest_ns / 1e3
        return min(FIRST_US * GROWTH ** percentile(self.counts, share), self.largest_ns / 1e3)

    def report(self) -> dict[str, Any]:
        """Percentiles, and upper edges of the used bins [us] with their counts."""
        used = {f"{FIRST_US * GROWTH**place:.0f}": n for place, n in enumerate(self.counts) if n}
        return {
            "count": self.total,
            **{key: round(self.percentile_us(SHARES[k]), 1) for k, key in KEYS.items()},
            "bins_us": used,
        }
