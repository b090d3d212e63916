# SPDX-License-Identifier: Apache-2.0
"""Stamps of samples: written as dates or times of day, and the order in which they come."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, datetime, time, timezone
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.numbers import is_missing

SEPARATE = 1.5
"""steps forward in a file that mixes the rows of one recording are as short as one period; in
several recordings by different clocks they are two periods of the sorted stamps or more"""
DAY, DAY_LENGTH = date(2000, 1, 1), 86400.0
"""date of times of day; [s]"""
SHORTEST = 10
"""samples of the shortest recording"""


def seconds_of(texts: Sequence[str], lines: Iterable[int], where: str) -> np.ndarray:
    """Seconds since the first of ISO 8601 stamps, or of times of day, shape (rows,).

    NaN for an empty cell.

    Raises:
        FlatplankError: the first text that is no stamp.
    """
    out = np.full(len(texts), np.nan)
    first: datetime | None = None
    last, days = 0.0, 0.0
    for row, (text, line) in enumerate(zip(texts, lines, strict=True)):
        if is_missing(text):
            continue
        stamp = _stamp(text)
        if stamp is None:
            raise FlatplankError(
                f"'{text}' is neither a number nor a stamp as 2024-05-01T10:00:00.250",
                f"{where}, line {line}", "write the time in s",
            )  # fmt: skip
        first = first or stamp
        seconds = (stamp - first).total_seconds()
        if stamp.date() == DAY and last - seconds > 0.5 * DAY_LENGTH:  # past midnight
            days += DAY_LENGTH
        last, out[row] = seconds, seconds + days
    return out


def _stamp(text: str) -> datetime | None:
    if _FRACTION_OF_MINUTE.search(text):  # minutes and seconds, or hours and minutes
        return None
    text = _FRACTION.sub(_microseconds, text.strip().replace("Z", "+00:00"))
    for read in (datetime.fromisoformat, _of_day):
        try:
            stamp = read(text)
        except ValueError:
            continue
        return stamp if stamp.tzinfo else stamp.replace(tzinfo=timezone.utc)
    return None


def _of_day(text: str) -> datetime:
    return datetime.combine(DAY, time.fromisoformat(text))


_FRACTION_OF_MINUTE = re.compile(r"(?<![\d:])\d+:\d+[.,]")
_FRACTION = re.compile(r"[.,](\d+)")


def _microseconds(fraction: re.Match[str]) -> str:
    """A fraction of a second with the six digits that every Python reads."""
    return f".{fraction[1][:6]:0<6}"


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
