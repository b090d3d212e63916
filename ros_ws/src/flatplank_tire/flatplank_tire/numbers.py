# SPDX-License-Identifier: Apache-2.0
"""Reads numbers as people and programs write them: decimal comma, thousands, D exponents.

The style of a column follows from its cells, else from the other columns of the file: a single
`1,234` may be 1.234 or 1234.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from flatplank_tire.errors import FlatplankError

MISSING = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "notavail"})
"""words for no value, in lower case"""
_SIGN, _EXPONENT = "[-+\N{MINUS SIGN}]?", "(?:[eEdD][-+]?[0-9]+)?"
_GROUPS = (
    "'\N{RIGHT SINGLE QUOTATION MARK} \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}"
)
"""marks between groups of three digits besides point and comma"""
_LOOSE = re.compile(f"{_SIGN}(?=[.,]?[0-9])[0-9.,{_GROUPS}]*[0-9.,]{_EXPONENT}")
_INFINITE = re.compile(r"[-+]?inf(?:inity)?", re.IGNORECASE)


@dataclass(frozen=True)
class NotNumbers:
    """Cells of a column that are neither empty nor a number."""

    count: int
    rows: int
    """cells of the column"""
    first: str
    """the first, quoted, and its place: `'OVL' in line 12`"""

    def __str__(self) -> str:
        return f"{self.count} of {self.rows} cells are not numbers, first {self.first}"


class NumberStyle(NamedTuple):
    """How numbers are written."""

    decimal: str
    groups: str
    """marks that may stand between groups of three digits"""


POINT, COMMA = NumberStyle(".", _GROUPS + ","), NumberStyle(",", _GROUPS + ".")


def looks_like_number(text: str) -> bool:
    """True for one number in any style."""
    text = text.strip()
    return bool(_LOOSE.fullmatch(text) or _INFINITE.fullmatch(text))


def is_missing(text: str) -> bool:
    """True for an empty cell and for words that stand for no value."""
    return text.strip().lower() in MISSING


@lru_cache
def pattern_of(style: NumberStyle) -> str:
    """Regular expression of a number in this style."""
    decimal = re.escape(style.decimal)
    # one kind of mark in a number: 1.234.567, not 1.234'567
    whole = "|".join(f"[1-9][0-9]{{0,2}}(?:{re.escape(m)}[0-9]{{3}})+" for m in style.groups)
    body = f"(?:(?:{whole}|[0-9]+)(?:{decimal}[0-9]*)?|{decimal}[0-9]+)"
    return f"{_SIGN}{body}{_EXPONENT}"


def number_of(text: str, style: NumberStyle = POINT) -> float | None:
    """The number; NaN for a missing value, None for other text."""
    text = text.strip()
    if text.lower() in MISSING:
        return float("nan")
    if not re.fullmatch(pattern_of(style), text):
        return float(text) if _INFINITE.fullmatch(text) else None
    for mark in style.groups:
        text = text.replace(mark, "")
    text = text.replace(style.decimal, ".").replace("\N{MINUS SIGN}", "-")
    return float(text.replace("d", "e").replace("D", "e"))


class Votes(NamedTuple):
    """How the cells of a column can be read."""

    balance: int
    """numbers with a decimal comma alone, less those with a decimal point alone"""
    doubtful: bool
    """a comma may be decimal or between thousands"""
    grouped: bool
    """a number has two marks"""


def styles_from(columns: Mapping[str, Votes]) -> dict[str, NumberStyle | None]:
    """Style of each column; None: commas may be decimal or between thousands."""
    every = sum(votes.balance for votes in columns.values())
    grouped = any(votes.grouped for votes in columns.values())
    found: dict[str, NumberStyle | None] = {}
    for name, votes in columns.items():
        decides = votes.balance or every
        style = COMMA if decides > 0 else POINT
        # a lone 1.234 among 0,5 and 0,25 is rather damage than 1234
        alone = bool(votes.balance) and not grouped
        found[name] = NumberStyle(style.decimal, _GROUPS) if alone else style
        if not decides and votes.doubtful:
            found[name] = None
    return found


def known_style(style: NumberStyle | None, cells: Iterable[str], where: str) -> NumberStyle:
    """The style; raises FlatplankError with a doubtful cell where there is none."""
    if style is not None:
        return style
    doubtful = next(c for c in cells if number_of(c) is not None and "," in c)
    raise FlatplankError(
        f"'{doubtful}' may be {doubtful.replace(',', '.')} or {doubtful.replace(',', '')}",
        where, "write the numbers with a decimal point",
    )  # fmt: skip


def cell_numbers(cells: Sequence[str], where: str) -> tuple[np.ndarray, np.ndarray]:
    """Values of trimmed cells of one style, NaN where there is none; and a mask of the cells with
    other text.

    Shapes (cells,). Raises FlatplankError where a comma may be decimal or between thousands.
    """
    other = np.zeros(len(cells), dtype=bool)
    if not any("_" in cell for cell in cells):  # Python reads 1_000, no file means it so
        try:
            return np.array(cells, dtype=float), other
        except ValueError:
            pass
    style = known_style(styles_from({"": _votes(cells)})[""], cells, where)
    numbers = [number_of(cell, style) for cell in cells]
    other[:] = [number is None for number in numbers]
    return np.array([np.nan if number is None else number for number in numbers]), other


def _votes(cells: Iterable[str]) -> Votes:
    balance, doubtful, grouped = 0, False, False
    for cell in cells:
        point, comma = (bool(re.fullmatch(pattern_of(style), cell)) for style in (POINT, COMMA))
        balance += comma - point
        doubtful |= comma and "," in cell
        grouped |= (point or comma) and len(re.findall("[.,]", cell)) > 1
    return Votes(balance, doubtful, grouped)
