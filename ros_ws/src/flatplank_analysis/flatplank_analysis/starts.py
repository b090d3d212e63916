# SPDX-License-Identifier: Apache-2.0
"""Means over runs whose wheel started at different angles: every start angle counts once.

What turns with the wheel cancels in the mean of the start angles 0, 120, 240 deg (section 6.2),
but not in the mean of runs of which one angle has more than another. Everything downstream of
runs is averaged here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

Item = TypeVar("Item")
THIRDS = {1, 2, 3}
"""start positions that cancel what turns once or twice with the wheel"""


@dataclass(frozen=True)
class Value:
    """A quantity in SI with its standard error and the number of runs behind it."""

    value: float
    std_error: float = math.nan
    runs: int = 1
    note: str = ""


def by_start(items: Sequence[Item], starts: Sequence[int]) -> list[list[Item]]:
    """The items of each start position, in the order in which the positions appear."""
    groups: dict[int, list[Item]] = {}
    for item, start in zip(items, starts, strict=True):
        groups.setdefault(start, []).append(item)
    return list(groups.values())


def mean_over_starts(values: Sequence[Any], starts: Sequence[int]) -> Any:
    """Mean of the start positions, each the mean of its runs.

    values: numbers or arrays of one shape, one per run; starts: position 1, 2 or 3 of each run.
    """
    return np.mean([np.mean(group, axis=0) for group in by_start(values, starts)], axis=0)


def value_over_starts(values: Sequence[float], starts: Sequence[int], note: str = "") -> Value:
    """The same of the finite values, with its standard error; NaN for a single run.

    With all three positions and repeats of them the error is that of the repeats, because what
    turns with the wheel cancels. Otherwise it is the scatter of the positions, an upper limit.
    """
    known = [(v, s) for v, s in zip(values, starts, strict=True) if math.isfinite(v)]
    if not known:
        return Value(math.nan, math.nan, 0, note or "not measured")
    numbers, places = zip(*known, strict=True)
    mean = float(mean_over_starts(numbers, places))
    return Value(mean, _error(by_start(numbers, places), set(places)), len(numbers), note)


def _error(groups: Sequence[Sequence[float]], places: set[int]) -> float:
    """Standard error of the mean of the groups' means."""
    count = sum(len(group) for group in groups)
    spare = count - len(groups)
    if len(groups) == 1 or (spare and places >= THIRDS):
        if not spare:
            return math.nan
        variance = sum(float(np.var(group)) * len(group) for group in groups) / spare
        return math.sqrt(variance * sum(1.0 / len(group) for group in groups)) / len(groups)
    means = [float(np.mean(group)) for group in groups]
    return float(np.std(means, ddof=1)) / math.sqrt(len(means))
