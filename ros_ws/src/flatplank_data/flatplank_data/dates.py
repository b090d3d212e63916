# SPDX-License-Identifier: Apache-2.0
"""Reads stamps written as dates or times of day: ISO 8601, or as a country writes them.

`01.05.2024` has its day first, `2024/05/01` its year. `05/01/2024` may be read in two ways: the
days of the column decide, or both ways give the same seconds, as within one day.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from datetime import date, datetime, time, timezone

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_tire.numbers import is_missing

DAY, DAY_LENGTH = date(2000, 1, 1), 86400.0
"""date of times of day; [s]"""
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_DATE = re.compile(r"(\d{4}|\d{1,2})([./-])(\d{1,2}|[A-Za-z]{3})\2(\d{4}|\d{1,2})(?=$|[\sT,])")
_ISO_DATE = re.compile(r"\d{4}-\d{2}-\d{2}(?!\d)")
_HALF_OF_DAY = re.compile(r"(?<!\d)(\d{1,2})(:[\d:.,]+)\s*([ap])\.?m\.?$", re.IGNORECASE)
_HOUR = re.compile(r"(?:^|(?<=[T ]))\d(?=:)")
_FRACTION_OF_MINUTE = re.compile(r"(?<![\d:])\d+:\d+[.,]")
_FRACTION = re.compile(r"[.,](\d+)")
_ORDERS = {".": ("dmy", "ymd"), "/": ("dmy", "mdy", "ymd"), "-": ("dmy", "mdy", "ymd")}
"""mark between day, month and year -> the orders in which they come"""


def seconds_of(texts: Sequence[str], lines: Iterable[int], where: str) -> np.ndarray:
    """Seconds since the first of stamps or times of day, shape (rows,); NaN for an empty cell.

    Raises:
        FlatplankError: the first text that is no stamp, or dates that may be read in two ways.
    """
    rows = [(text.strip(), line) for text, line in zip(texts, lines, strict=True)]
    first = next((text for text, _ in rows if not is_missing(text)), "")
    found: list[np.ndarray] = []
    told: list[FlatplankError] = []
    for order in list(_orders(first)) or [""]:
        try:
            found.append(_seconds(rows, order, where))
        except FlatplankError as error:
            told.append(error)
    if not found:
        raise told[0]
    if any(not np.array_equal(found[0], other, equal_nan=True) for other in found[1:]):
        raise FlatplankError(
            f"'{first}' may have its day, its month or its year first",
            where, "write the dates as 2024-05-31, or the time in s",
        )  # fmt: skip
    return found[0]


def _orders(text: str) -> Iterator[str]:
    """Orders of day, month and year that a date may have; none for ISO 8601 and without a date."""
    found = _DATE.match(text)
    if not found or _ISO_DATE.match(text):
        return
    fields = (found[1], found[3], found[4])
    if any(len(f) == 4 for f in (found[1], found[4])):
        year = next(k for k in (0, 2) if len(fields[k]) == 4)
        yield from (o for o in _ORDERS[found[2]] if o.index("y") == year)
    else:
        yield from _ORDERS[found[2]]


def _seconds(rows: Sequence[tuple[str, int]], order: str, where: str) -> np.ndarray:
    out = np.full(len(rows), np.nan)
    first: datetime | None = None
    last, days = 0.0, 0.0
    for row, (text, line) in enumerate(rows):
        if is_missing(text):
            continue
        stamp = _stamp(text, order)
        if stamp is None:
            raise FlatplankError(
                f"'{text}' is neither a number nor a stamp as 2024-05-31T10:00:00.250",
                f"{where}, line {line}", "write the time in s",
            )  # fmt: skip
        first = first or stamp
        seconds = (stamp - first).total_seconds()
        if stamp.date() == DAY and last - seconds > 0.5 * DAY_LENGTH:  # past midnight
            days += DAY_LENGTH
        last, out[row] = seconds, seconds + days
    return out


def _stamp(text: str, order: str) -> datetime | None:
    if _FRACTION_OF_MINUTE.search(text):  # minutes and seconds, or hours and minutes
        return None
    try:
        text = _iso(text, order)
    except ValueError:
        return None
    for read in (datetime.fromisoformat, _of_day):
        try:
            stamp = read(text)
        except ValueError:
            continue
        return stamp if stamp.tzinfo else stamp.replace(tzinfo=timezone.utc)
    return None


def _iso(text: str, order: str) -> str:
    """The text in ISO 8601. Raises ValueError for a date of another order."""
    if order:
        found = _DATE.match(text)
        if not found:
            raise ValueError(text)
        day = _date(dict(zip(order, (found[1], found[3], found[4]), strict=True)))
        rest = text[found.end() :].lstrip(" ,T")
        text = f"{day.isoformat()}T{rest}" if rest else day.isoformat()
    text = _HALF_OF_DAY.sub(_of_24_hours, text)
    text = _HOUR.sub(lambda hour: f"0{hour[0]}", text)
    return _FRACTION.sub(_microseconds, text.replace("Z", "+00:00"))


def _date(fields: dict[str, str]) -> date:
    """A date of its fields d, m, y; a year of two digits is one of this century."""
    month, year = fields["m"].lower(), fields["y"]
    number = MONTHS.index(month) + 1 if month.isalpha() else int(month)
    if len(fields["d"]) > 2 or len(year) not in (2, 4):
        raise ValueError(fields)
    return date(int(year) + (2000 if len(year) == 2 else 0), number, int(fields["d"]))


def _of_24_hours(found: re.Match[str]) -> str:
    """`1:30 pm` as 13:30."""
    hour = int(found[1])
    if not 1 <= hour <= 12:
        raise ValueError(found[0])
    return f"{hour % 12 + (12 if found[3].lower() == 'p' else 0):02d}{found[2]}"


def _of_day(text: str) -> datetime:
    return datetime.combine(DAY, time.fromisoformat(text))


def _microseconds(fraction: re.Match[str]) -> str:
    """A fraction of a second with the six digits that every Python reads."""
    return f".{fraction[1][:6]:0<6}"
