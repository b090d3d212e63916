# SPDX-License-Identifier: Apache-2.0
"""The order in which the stamps of samples come."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

SEPARATE = 1.5
"""steps forward in a file that mixes the rows of one recording are as short as one period; in
several recordings by different clocks they are two periods of the sorted stamps or more"""
SHORTEST = 10
"""samples of the shortest recording"""


class Order(NamedTuple):
    """Order of the samples of a table."""

    rows: np.ndarray | None
    """rows in the order of time; None: as they are"""
    back: int
    """number of the first row whose stamp is before that of the row above; 0 without one"""
    recordings: int
    """number of recordings, each in order of time, that follow one another"""


def order_of(stamps: np.ndarray, shortest: int = SHORTEST) -> Order:
    """How samples with these stamps [s] are ordered; shortest: samples of the shortest recording.

    The rows of one recording in another order (sorted by slip, say) are in order of time when they
    are sorted. Rows of several recordings, whose clocks start again, are not: sorting would mix
    them. In each of those, neighbouring rows are one period apart, which is two periods or more of
    all stamps together; rows of one recording have neighbours as close as the sorted stamps.
    """
    step = np.diff(stamps)
    down = step < 0.0
    if not down.any():
        return Order(None, 0, 1)
    back = int(np.argmax(down)) + 2
    rows = np.argsort(stamps, kind="stable")
    period = np.diff(stamps[rows])
    if (period > 0.0).all():
        forward = step[step > 0.0]
        short = len(stamps) < shortest * (1 + down.sum())
        if short or forward.min() < SEPARATE * np.percentile(period, 25):
            return Order(rows, back, 1)
    return Order(None, back, 1 + int(down.sum()))


def in_order(columns: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[str]]:
    """The columns in the order of their column `time`, where sorting is certain; and a remark.

    It is certain where the plank travels less far to and fro in order of time than in the file.
    """
    stamps, position = columns.get("time"), columns.get("plank_position")
    if stamps is None or position is None or not np.isfinite(stamps).all():
        return dict(columns), []
    order = order_of(stamps)
    if order.rows is None or not _way(position[order.rows]) < _way(position):
        return dict(columns), []
    told = f"rows are not in order of time (row {order.back}): sorted by the column 'time'"
    return {name: values[order.rows] for name, values in columns.items()}, [told]


def _way(position: np.ndarray) -> float:
    return float(np.abs(np.diff(position)).sum())
