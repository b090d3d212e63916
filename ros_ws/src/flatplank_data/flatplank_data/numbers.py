# SPDX-License-Identifier: Apache-2.0
"""Numbers of columns of text, by Arrow; how a number is written: `flatplank_tire.numbers`."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from flatplank_tire.numbers import (
    COMMA,
    POINT,
    NumberStyle,
    Votes,
    known_style,
    number_of,
    pattern_of,
    styles_from,
)

_SIMPLE = r"^-?[0-9]+(?:D[0-9]*)?(?:[eE][-+]?[0-9]+)?$"


def styles_of(columns: Mapping[str, pa.Array]) -> dict[str, NumberStyle | None]:
    """Style of each column of trimmed cells; None: commas may be decimal or between thousands."""
    return styles_from({name: _votes(cells) for name, cells in columns.items()})


def _votes(cells: pa.Array) -> Votes:
    point, comma = (
        pc.match_substring_regex(cells, f"^(?:{pattern_of(style)})$") for style in (POINT, COMMA)
    )
    both = pc.match_substring_regex(cells, "[.,].*[.,]")
    return Votes(
        _count(pc.and_not(comma, point)) - _count(pc.and_not(point, comma)),
        _count(pc.and_(comma, pc.match_substring(cells, ","))) > 0,
        _count(pc.and_(both, pc.or_(point, comma))) > 0,
    )


def _count(mask: pa.Array) -> int:
    return pc.sum(mask).as_py() or 0


def numbers_of(
    cells: pa.Array, style: NumberStyle | None, where: str
) -> tuple[np.ndarray, np.ndarray]:
    """Values of trimmed cells, NaN where there is none; and a mask of the cells with other text.

    Shapes (cells,). Raises FlatplankError for a style that is not known.
    """
    style = known_style(style, () if style else cells.to_pylist(), where)
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
