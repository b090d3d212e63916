# SPDX-License-Identifier: Apache-2.0
"""Reads text tables: names, perhaps units, and one line per sample, with any usual separator.

Tab, semicolon, comma, bar or blanks separate; titles and comments may stand before the names. A
line without numbers between the samples is left out with a remark; a line with too few or too many
cells is an error.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pyarrow as pa

from flatplank_data.dates import seconds_of
from flatplank_data.errors import FlatplankError
from flatplank_data.numbers import numbers_of, styles_of
from flatplank_data.units import is_unit
from flatplank_tire.numbers import NotNumbers, NumberStyle, is_missing, looks_like_number
from flatplank_tire.text import decode_text, lines_of

SEPARATORS = ("\t", ";", ",", "|", " ")
"""in the order in which they are tried: a comma may be decimal, a blank may be in a name"""
_COMMENTS = ("#", "%", "//", "!")
_START = 400
"""lines from which the separator is found"""
_QUOTED = 40
"""characters of a line or cell that a message quotes"""
_HEADER = (
    re.compile(r"^\s*(.*?)\s*\[(.*)\]\s*$"),
    re.compile(r"^\s*(.*?)\s*\((.*)\)\s*$"),
    re.compile(r"^\s*(.*?)\s+/\s+(.+?)\s*$"),
)
"""`fx [N]`, `fx (N)`, `fx / N`"""
_REMEDY = "write a header and one line per sample"

Line = tuple[int, str]
"""number and text"""


class Cells(NamedTuple):
    """Values of one column, shapes (rows,)."""

    values: np.ndarray
    """NaN where the cell is empty or no number"""
    other: np.ndarray
    """mask of the cells that are neither empty nor a number"""


@dataclass(frozen=True)
class TextTable:
    """Cells of a text table as written."""

    where: str
    names: Sequence[str]
    units: Mapping[str, str]
    """units of the columns that state one"""
    lines: np.ndarray
    """number of the line of each row, shape (rows,)"""
    remarks: Sequence[str]
    texts: Mapping[str, pa.Array]
    styles: Mapping[str, NumberStyle | None]

    def column(self, name: str) -> Cells:
        """A column as numbers. Raises FlatplankError when its decimal mark cannot be known."""
        where = f"{self.where}, column '{name}'"
        return Cells(*numbers_of(self.texts[name], self.styles[name], where))

    def time(self, name: str) -> np.ndarray:
        """A column of times as numbers, or as seconds since the first; see `seconds_of`.

        NaN for an empty cell. Raises FlatplankError for a text that is neither.
        """
        values, other = self.column(name)
        if not other.any():
            return values
        if np.isfinite(values[: np.argmax(other)]).any():
            where = f"{self.where}, column '{name}'"
            what = f"{self.first(name, other)} is not a number as those above"
            raise FlatplankError(what, where, "correct or remove the line")
        return seconds_of(self.texts[name].to_pylist(), self.lines, self.where)

    def not_numbers(self, name: str, other: np.ndarray) -> NotNumbers:
        """The cells of a column with other text, by their mask of shape (rows,)."""
        return NotNumbers(np.count_nonzero(other), len(other), self.first(name, other))

    def first(self, name: str, rows: np.ndarray) -> str:
        """The first of these rows (a mask) of a column: `'OVL' in line 12`."""
        row = np.argmax(rows)
        text = self.texts[name][row].as_py()
        quoted = f"'{_short(text)}'" if text else "empty cell"
        return f"{quoted} in line {self.lines[row]}"


def read_text_table(
    data: bytes, where: str, is_known: Callable[[str], bool] = lambda name: False
) -> TextTable:
    """Read a text table; is_known: whether a column's name is known, to find the line of names.

    Raises:
        FlatplankError: no names, no samples, or a line with another number of cells.
    """
    every = enumerate(lines_of(decode_text(data, where)), start=1)
    lines = [(number, line) for number, line in every if line.strip()]
    separator, first, head = _layout(lines, where)
    names, units, last = _names_and_units(list(head.values()), is_known, where)
    after = [line for line in lines[list(head)[last] + 1 : first] if not _is_comment(line[1])]
    body, remarks = _samples([*after, *lines[first:]], separator, len(names), where)
    cells = zip(*(c for _, c in body), strict=True)
    texts = {n: pa.array(c, pa.string()) for n, c in zip(names, cells, strict=True)}
    numbers = np.array([number for number, _ in body])
    return TextTable(where, names, units, numbers, remarks, texts, styles_of(texts))


def split_cells(line: str, separator: str) -> list[str]:
    """Trimmed cells of a line; a cell in quotes may contain the separator."""
    if '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    else:
        cells = line.split(separator)
    if separator == " ":
        return [cell for word in cells if (cell := word.strip())]
    return [cell.strip() for cell in cells]


def split_header(cells: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names and units of a header: `fx [N]`; a name without a unit has the unit ""."""
    names, units = [], []
    for cell in cells:
        match = next((m for pattern in _HEADER if (m := pattern.match(cell))), None)
        if match and match.re is _HEADER[2] and not is_unit(match.group(2)):
            match = None
        names.append(match.group(1) if match else cell)
        units.append((match.group(2).strip() or "-") if match else "")
    return names, units


def _layout(lines: Sequence[Line], where: str) -> tuple[str, int, dict[int, list[str]]]:
    """Separator, index of the first sample, and the lines of the header: index -> cells."""
    best: tuple[float, str, int, dict[int, list[str]]] | None = None
    no_head = ""
    for separator in SEPARATORS:
        rows = [split_cells(line, separator) for _, line in lines[:_START]]
        samples = [
            k for k, row in enumerate(rows) if _is_sample(row) and not _is_comment(lines[k][1])
        ]
        widths = Counter(len(rows[k]) for k in samples if len(rows[k]) > 1)
        if not widths:
            continue
        width, count = widths.most_common(1)[0]
        first = next(k for k in samples if len(rows[k]) == width)
        named = [k for k in range(first) if not _is_comment(lines[k][1])]
        head = {k: row for k in named if any(row := _as_wide(rows[k], rows[first]))}
        if not head:
            no_head = no_head or f"no header of {width} names before line {lines[first][0]}"
        elif best is None or count / len(samples) > best[0]:
            best = count / len(samples), separator, first, head
    if best:
        return best[1:]
    if no_head:
        raise FlatplankError(no_head, where, "write one")
    raise FlatplankError("no line of numbers", where, _REMEDY)


def _as_wide(head: list[str], sample: list[str]) -> list[str]:
    """A line before the samples as a line of the header; empty when its width is another."""
    lacking = len(sample) - len(head)
    if lacking == 1 and not sample[-1]:  # only the samples end with a separator
        return [*head, ""]
    return head[: len(sample)] if lacking <= 0 and not any(head[len(sample) :]) else []


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(_COMMENTS)


def _is_sample(cells: Sequence[str]) -> bool:
    """True for a line with a number; the `1` of a line of units is none."""
    numbers = [cell for cell in cells if looks_like_number(cell)]
    if not numbers or any(number != "1" for number in numbers):
        return bool(numbers)
    return not any(is_unit(cell) for cell in cells)


def _names_and_units(
    head: Sequence[Sequence[str]], is_known: Callable[[str], bool], where: str
) -> tuple[list[str], dict[str, str], int]:
    """Names: the line with most known ones, else that before the units; units; and the number of
    the last line of the header that is used."""
    lettered = [k for k, row in enumerate(head) if k and any(is_unit(cell) for cell in row)]
    known = [sum(is_known(name) for name in split_header(row)[0]) for row in head]
    at = known.index(max(known))
    if not max(known):
        at = lettered[-1] - 1 if lettered else len(head) - 1
    names, units = split_header(head[at])
    last = at
    if at + 1 < len(head) and not any(units):
        last = lettered[-1] if lettered and lettered[-1] > at else len(head) - 1
        units = list(head[last])
    seen: Counter[str] = Counter()
    for k, name in enumerate(names):
        seen[name] += 1
        if seen[name] > 1 and is_known(name):
            raise FlatplankError(f"two columns '{name}'", where, "rename or remove one")
        names[k] = name or f"column {k + 1}"
        if name and seen[name] > 1:
            names[k] = f"{name} ({seen[name]})"
    return names, {name: unit for name, unit in zip(names, units, strict=True) if unit}, last


def _samples(
    lines: Sequence[Line], separator: str, width: int, where: str
) -> tuple[list[tuple[int, list[str]]], list[str]]:
    """Cells of the samples by line, and a remark on the other lines."""
    body, others = [], []
    for number, line in lines:
        cells = split_cells(line, separator)
        if _is_comment(line) or not any(is_missing(c) or looks_like_number(c) for c in cells):
            others.append((number, line))
        elif len(cells) == width:
            body.append((number, cells))
        else:
            raise FlatplankError(
                f"{len(cells)} values for {width} columns (cut short?)",
                f"{where}, line {number}", "correct or remove the line",
            )  # fmt: skip
    if not body:
        raise FlatplankError("no samples", where, _REMEDY)
    if not others:
        return body, []
    number, line = others[0]
    count = (
        "1 line is no sample and was"
        if len(others) == 1
        else f"{len(others)} lines are no samples and were"
    )
    return body, [f"{count} left out: line {number} '{_short(line)}'"]


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= _QUOTED else f"{text[:_QUOTED]} ..."
