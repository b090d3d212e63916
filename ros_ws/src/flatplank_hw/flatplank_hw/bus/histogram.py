# SPDX-License-Identifier: Apache-2.0
"""Counts by place, and the place that a share of them does not exceed."""

from __future__ import annotations

from collections.abc import Sequence


def percentile(counts: Sequence[int], share: float) -> int:
    """Smallest place that `share` of all counts do not exceed; 0 when there are none."""
    wanted, seen = share * sum(counts), 0
    for place, count in enumerate(counts):
        seen += count
        if count and seen >= wanted:
            return place
    return 0
