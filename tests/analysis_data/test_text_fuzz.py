# SPDX-License-Identifier: Apache-2.0
"""Thousands of damaged text files: each is read as pandas reads it, or refused in one line."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from test_text_tables import NAMES, ROWS, a_campaign, written
from text_damage import damaged

from flatplank_data.delimited import SEPARATORS, TextTable, read_text_table, split_cells
from flatplank_data.errors import FlatplankError
from flatplank_data.text import decode_text, lines_of
from flatplank_data.tydex import Channel, Quantity, TydexFile, format_tydex, parse_tydex

SHORT = ROWS[:12]
KINDS = {
    "comma": written(",", "point", SHORT),
    "semicolon": written(";", "comma", SHORT, ["time;plank_position;fx;fz", "s;m;N;N"]),
    "tab": written("\t", "comma, thousands by point", SHORT, ["Run 3", "\t".join(NAMES)]),
    "blanks": written(" ", "point", SHORT),
}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "cp1252")


def read(function, *arguments):
    """What a reader gives; None for a refusal, which is one line with the name of the file."""
    try:
        return function(*arguments)
    except FlatplankError as error:
        assert "\n" not in str(error) and error.what and error.where.startswith("a.")
        return None


def left_out(table: TextTable) -> int:
    """Lines that are told to be left out."""
    counts = (re.match(r"(\d+) lines? (?:is|are) no sample", text) for text in table.remarks)
    return sum(int(count[1]) for count in counts if count)


def compare_with_pandas(table: TextTable, data: bytes) -> None:
    """Each line is a row or told to be left out, and each number is that of pandas."""
    lines = lines_of(decode_text(data, "a.csv"))
    first = int(table.lines[0])
    filled = [line for line in lines[first - 1 :] if line.strip()]
    assert len(table.lines) + left_out(table) == len(filled)
    widths = {m: len(split_cells(lines[first - 1], m)) for m in SEPARATORS}
    separator = next(m for m, width in widths.items() if width == len(table.names))
    rows = [split_cells(lines[number - 1], separator) for number in table.lines]
    cells = pd.DataFrame(rows, columns=list(table.names), dtype=str)
    for name in table.names:
        style = table.styles[name]
        if style is None:
            assert read(table.column, name) is None
            continue
        values, other = table.column(name)
        mark = "." if style.decimal == "," else ","
        plain = cells[name]
        if mark in style.groups:
            plain = plain.str.replace(rf"(?<=\d)[{mark}'](?=\d{{3}}(?!\d))", "", regex=True)
        plain = plain.str.replace(style.decimal, ".")
        by_pandas = pd.to_numeric(plain.str.replace("(?i)^(none|n/a|notavail)$", "nan",
                                                    regex=True), errors="coerce")  # fmt: skip
        numbers = np.isfinite(values) & by_pandas.notna().to_numpy()
        np.testing.assert_allclose(values[numbers], by_pandas[numbers], rtol=1e-12)
        # what pandas reads is never no value here: it is a number, or counted as other text
        assert not (by_pandas.notna() & np.isnan(values) & ~other).any()


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_tables_are_read_as_by_pandas_or_refused(kind):
    random = np.random.default_rng(list(KINDS).index(kind))
    outcomes = {True: 0, False: 0}
    for k in range(800):
        data = damaged(KINDS[kind].encode(ENCODINGS[k % len(ENCODINGS)]), random)
        table = read(read_text_table, data, "a.csv", NAMES.__contains__)
        outcomes[table is not None] += 1
        if table is not None:
            compare_with_pandas(table, data)
    assert min(outcomes.values()) > 80, outcomes


def test_undamaged_tables_pass_the_comparison():
    for text in KINDS.values():
        for encoding in ENCODINGS:
            data = text.encode(encoding)
            table = read_text_table(data, "a.csv", NAMES.__contains__)
            assert len(table.lines) == len(SHORT) and left_out(table) == 0
            compare_with_pandas(table, data)
    with pytest.raises(AssertionError):  # a reader that loses a row is noticed
        compare_with_pandas(
            read_text_table(data, "a.csv"), data + KINDS["blanks"].splitlines()[3].encode()
        )


def test_random_bytes_are_refused():
    random = np.random.default_rng(4)
    for _ in range(500):
        data = random.bytes(int(random.integers(1, 400)))
        table = read(read_text_table, data, "a.csv")
        if table is not None:
            compare_with_pandas(table, data)


def test_damaged_campaigns_lose_no_row_without_a_word(tmp_path):
    random = np.random.default_rng(5)
    text = written(";", "comma").encode()
    used = 0
    for _ in range(250):
        campaign = a_campaign(tmp_path, damaged(text, random))
        tables = list(campaign.tables())
        told = "\n".join(map(str, campaign.problems))
        assert len(campaign.problems) == len(told.splitlines())
        if not tables:
            assert campaign.problems
            continue
        used += 1
        (table,) = tables
        lines = [line for line in lines_of((tmp_path / "r.csv").read_text("cp1252"))]
        rows = sum(bool(re.match(r"[\d-]", line)) for line in lines)
        assert len(table) >= rows or "left out" in told, told
    assert used > 25


TYDEX = format_tydex(
    TydexFile(
        {"RELEASE": "1.3", "DATE": "03-May-2024"}, ["made up"],
        {"LONGSLIP": Quantity("%", "5.0"), "FZW": Quantity("kN", "3.7")},
        [Channel(*c) for c in (("RUNTIME", "s"), ("TRAVDIST", "m"), ("FX", "N"), ("FZW", "N"))],
        SHORT,
    )
)  # fmt: skip


def test_damaged_tydex_files_are_read_or_refused():
    random = np.random.default_rng(6)
    outcomes = {True: 0, False: 0}
    for _ in range(1500):
        data = damaged(TYDEX.encode("cp1252"), random)
        file = read(lambda d: parse_tydex(decode_text(d, "a.tdx"), "a.tdx"), data)
        outcomes[file is not None] += 1
        keywords = re.compile(r"^[*][*][A-Z]+", re.M)
        text = decode_text(data, "a.tdx") if file is not None else ""
        if file is not None and keywords.findall(text) == keywords.findall(TYDEX):
            text = decode_text(data, "a.tdx")
            body = text.split("**MEASURDATA")[1].split("**END")[0].split("\n", 1)[1]
            body = "\n".join(line for line in lines_of(body) if not line.startswith(("!", "**")))
            cells = pd.Series(re.findall(r"\S+", body))
            numbers = pd.to_numeric(cells.str.replace(",", "."), errors="coerce")
            if cells.str.len().max() <= 10:
                assert file.data.size == len(cells)
                factors = [(c.factor, c.before, c.after) for c in file.channels]
                if factors == [(1.0, 0.0, 0.0)] * len(factors) and numbers.notna().all():
                    np.testing.assert_allclose(file.data.ravel(), numbers, rtol=1e-12)
    assert min(outcomes.values()) > 150, outcomes
