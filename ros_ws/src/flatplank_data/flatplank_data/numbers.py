# SPDX-License-Identifier: Apache-2.0
"""Reads numbers as people and programs write them: decimal comma, thousands, D exponents.

The style of a column follows from its cells, else from the other columns of the file: a single
`1,234` may be 1.234 or 1234.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from flatplank_data.errors import FlatplankError

MISSING = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "notavail"})
"""words for no value, in lower case"""
_SIGN, _EXPONENT = "[-+\N{MINUS SIGN}]?", "(?:[eEdD][-+]?[0-9]+)?"
_GROUPS = (
    "'\N{RIGHT SINGLE QUOTATION MARK} \N{NO-BREAK SPACE}\N{NARROW NO-BREAK SPACE}\N{THIN SPACE}"
)
"""marks between groups of three digits besides point and comma"""
_LOOSE = re.compile(f"{_SIGN}(?=[.,]?[0-9])[0-9.,{_GROUPS}]*[0-9.,]{_EXPONENT}")
_INFINITE = re.compile(r"[-+]?inf(?:inity)?", re.IGNORECASE)
_SIMPLE = r"^-?[0-9]+(?:D[0-9]*)?(?:[eE][-+]?[0-9]+)?$"


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
def _pattern(style: NumberStyle) -> str:
    decimal = re.escape(style.decimal)
    # one kind of mark in a number: 1.234.567, not 1.234'567
    whole = "|".join(f"[1-9][0-9]{{0,2}}(?:{re.escape(m)}[0-9]{{3}})+" for m in style.groups)
    body = f"(?:(?:{whole}|[0-9]+)(?:{decimal}[0-9]*)?|{decimal}[0-9]+)"
    return f"{_SIGN}{body}{_EXPONENT}"


def styles_of(columns: Mapping[str, pa.Array]) -> dict[str, NumberStyle | None]:
    """Style of each column of trimmed cells; None: commas may be decimal or between thousands."""
    votes: dict[str, int] = {}
    doubtful = set()
    grouped = False
    for name, cells in columns.items():
        point, comma = (
            pc.match_substring_regex(cells, f"^(?:{_pattern(style)})$") for style in (POINT, COMMA)
        )
        votes[name] = _count(pc.and_not(comma, point)) - _count(pc.and_not(point, comma))
        if not votes[name] and _count(pc.and_(comma, pc.match_substring(cells, ","))):
            doubtful.add(name)
        both = pc.match_substring_regex(cells, "[.,].*[.,]")
        grouped |= _count(pc.and_(both, pc.or_(point, comma))) > 0
    every = sum(votes.values())
    found: dict[str, NumberStyle | None] = {}
    for name, vote in votes.items():
        decides = vote or every
        style = COMMA if decides > 0 else POINT
        # a lone 1.234 among 0,5 and 0,25 is rather damage than 1234
        alone = bool(vote) and not grouped
        found[name] = NumberStyle(style.decimal, _GROUPS) if alone else style
        if not decides and name in doubtful:
            found[name] = None
    return found


def _count(mask: pa.Array) -> int:
    return pc.sum(mask).as_py() or 0


def number_of(text: str, style: NumberStyle = POINT) -> float | None:
    """The number; NaN for a missing value, None for other text."""
    text = text.strip()
    if text.lower() in MISSING:
        return float("nan")
    if not re.fullmatch(_pattern(style), text):
        return float(text) if _INFINITE.fullmatch(text) else None
    for mark in style.groups:
        text = text.replace(mark, "")
    text = text.replace(style.decimal, ".").replace("\N{MINUS SIGN}", "-")
    return float(text.replace("d", "e").replace("D", "e"))


def numbers_of(
    cells: pa.Array, style: NumberStyle | None, where: str
) -> tuple[np.ndarray, np.ndarray]:
    """Values of trimmed cells, NaN where there is none; and a mask of the cells with other text.

    Shapes (cells,). Raises FlatplankError for a style that is not known.
    """
    if style is None:
        doubtful = next(c for c in cells.to_pylist() if number_of(c) is not None and "," in c)
        raise FlatplankError(
            f"'{doubtful}' may be {doubtful.replace(',', '.')} or {doubtful.replace(',', '')}",
            where, "write the numbers with a decimal point",
        )  # fmt: skip
    pattern = _SIMPLE.replace("D", re.escape(style.decimal))
    simple = pc.match_substring_regex(cells, pattern)
    plain = pc.replace_substring(cells, style.decimal, ".") if style.decimal != "." else cells
    read = pc.if_else(simple, plain, pa.scalar(None, pa.string())).cast(pa.float64())
    values = np.array(read.to_numpy(zero_copy_only=False), dtype=np.float64)
    other = np.zeros(len(values), dtype=bool)
    rest = np.flatnonzero(~simple.to_numpy(zero_copy_only=False))
    for row, text in zip(rest, cells.take(pa.array(rest)).to_pylist(), strict=True):
        number = number_of(text, style)
        values[row], other[row] = (np.nan, True) if number is None else (number, False)
    return values, other
