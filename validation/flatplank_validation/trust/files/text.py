# SPDX-License-Identifier: Apache-2.0
"""Text tables and TYDEX files, and what pandas reads of them."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from flatplank_data.delimited import SEPARATORS, TextTable, read_text_table, split_cells
from flatplank_data.errors import FlatplankError
from flatplank_tire.text import decode_text, lines_of
from flatplank_tire.tydex import Channel, Quantity, TydexFile, format_tydex

NAMES = ["time", "plank_position", "fx", "fz"]
ROWS = np.column_stack([
    0.05 * np.arange(40),
    0.0015 * np.arange(40),
    -1234.5 + 61.73 * np.arange(40),
    3700.125 + np.sin(np.arange(40)),
])  # fmt: skip
SHORT = ROWS[:12]
STYLES = {
    "point": (".", "", "\t;,| "),
    "comma": (",", "", "\t;| "),
    "point, thousands by comma": (".", ",", "\t;| "),
    "comma, thousands by point": (",", ".", "\t;| "),
    "comma, thousands by blank": (",", "\N{NO-BREAK SPACE}", "\t;|"),
    "point, thousands by apostrophe": (".", "'", "\t;,| "),
}
"""decimal mark, mark of thousands, separators that go with them"""
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "cp1252")


def number(value: float, decimal: str, thousands: str) -> str:
    """A number in a style."""
    text = f"{value:,.4f}" if thousands else f"{value:.4f}"
    return "".join({",": thousands, ".": decimal}.get(mark, mark) for mark in text)


def written(
    separator: str, style: str, rows: np.ndarray = ROWS, head: Sequence[str] | None = None
) -> str:
    """A text table."""
    decimal, thousands, _ = STYLES[style]
    lines = [separator.join(number(v, decimal, thousands) for v in row) for row in rows]
    return "\r\n".join([*(head or [separator.join(NAMES)]), *lines, ""])


KINDS = {
    "comma": written(",", "point", SHORT),
    "semicolon": written(";", "comma", SHORT, ["time;plank_position;fx;fz", "s;m;N;N"]),
    "tab": written("\t", "comma, thousands by point", SHORT, ["Run 3", "\t".join(NAMES)]),
    "blanks": written(" ", "point", SHORT),
}


def left_out(table: TextTable) -> int:
    """Lines that are told to be left out."""
    counts = (re.match(r"(\d+) lines? (?:is|are) no sample", text) for text in table.remarks)
    return sum(int(count[1]) for count in counts if count)


def compare_with_pandas(table: TextTable, data: bytes) -> None:
    """Each line is a row or told to be left out, and each number is that of pandas."""
    lines = lines_of(decode_text(data, "a.csv"))
    first = int(table.lines[0])
    filled = [line for line in lines[first - 1 :] if line.strip()]
    counted = len(table.lines) + left_out(table)
    # lines between the header and the first sample count among those that are left out
    between = sum(1 for line in lines[: first - 1] if line.strip())
    assert len(filled) <= counted <= len(filled) + between, f"{counted} of {len(filled)} lines"
    widths = {m: len(split_cells(lines[first - 1], m)) for m in SEPARATORS}
    separator = next(m for m, width in widths.items() if width == len(table.names))
    rows = [split_cells(lines[number - 1], separator) for number in table.lines]
    for name, cells in zip(table.names, zip(*rows, strict=True), strict=True):
        _compare_column(table, name, cells)


_NONE = re.compile("none|n/a|notavail", re.IGNORECASE)


def _compare_column(table: TextTable, name: str, cells: Sequence[str]) -> None:
    style = table.styles[name]
    if style is None:
        try:
            table.column(name)
        except FlatplankError:
            return
        raise AssertionError(f"the marks of {name} are not known, and it was read")
    values, other = table.column(name)
    mark = "." if style.decimal == "," else ","
    if mark in style.groups:
        between = re.compile(rf"(?<=\d)[{mark}'](?=\d{{3}}(?!\d))")
        cells = [between.sub("", cell) for cell in cells]
    plain = ["nan" if _NONE.fullmatch(c) else c.replace(style.decimal, ".") for c in cells]
    by_pandas = pd.to_numeric(np.array(plain, dtype=object), errors="coerce")
    numbers = np.isfinite(values) & ~np.isnan(by_pandas)
    np.testing.assert_allclose(values[numbers], by_pandas[numbers], rtol=1e-12)
    # what pandas reads is never no value here: it is a number, or counted as other text
    assert not (~np.isnan(by_pandas) & np.isnan(values) & ~other).any(), name


def read_table(data: bytes, name: str = "a.csv") -> TextTable:
    """Read a text table with the names of runs."""
    return read_text_table(data, name, NAMES.__contains__)


TYDEX = format_tydex(
    TydexFile(
        {"RELEASE": "1.3", "DATE": "03-May-2024"}, ["made up"],
        {"LONGSLIP": Quantity("%", "5.0"), "FZW": Quantity("kN", "3.7")},
        [Channel(*c) for c in (("RUNTIME", "s"), ("TRAVDIST", "m"), ("FX", "N"), ("FZW", "N"))],
        SHORT,
    )
)  # fmt: skip
_KEYWORDS = re.compile(r"^[*][*][A-Z]+", re.M)


def compare_tydex(file: TydexFile, text: str) -> None:
    """Where the sections are whole, each word of the data is a value, and each number that of
    pandas."""
    if _KEYWORDS.findall(text) != _KEYWORDS.findall(TYDEX):
        return
    body = text.split("**MEASURDATA")[1].split("**END")[0].split("\n", 1)[1]
    body = "\n".join(line for line in lines_of(body) if not line.startswith(("!", "**")))
    cells = pd.Series(re.findall(r"\S+", body))
    if cells.str.len().max() > 10:
        return
    assert file.data.size == len(cells), f"{file.data.size} of {len(cells)} values"
    factors = [(c.factor, c.before, c.after) for c in file.channels]
    if factors != [(1.0, 0.0, 0.0)] * len(factors):
        return
    by_pandas = pd.to_numeric(cells.str.replace(",", "."), errors="coerce").to_numpy()
    values = file.data.ravel()
    both = np.isfinite(values) & np.isfinite(by_pandas)
    np.testing.assert_allclose(values[both], by_pandas[both], rtol=1e-12)
    lost = int((np.isnan(values) & np.isfinite(by_pandas)).sum())
    assert lost <= sum(n.count for n in file.not_numbers.values()), f"{lost} values lost"
