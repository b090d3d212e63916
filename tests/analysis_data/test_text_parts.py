# SPDX-License-Identifier: Apache-2.0
"""Texts, lines and numbers of files, one by one; what a packed part of a file may unpack to."""

from __future__ import annotations

import bz2
import math

import lz4.frame
import numpy as np
import pyarrow as pa
import pytest
import zstandard

from flatplank_data import guard
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget, DamagedError
from flatplank_data.numbers import numbers_of, styles_of
from flatplank_tire.numbers import (
    COMMA,
    POINT,
    NotNumbers,
    NumberStyle,
    cell_numbers,
    is_missing,
    looks_like_number,
    number_of,
)
from flatplank_tire.text import decode_text, lines_of

NBSP, THIN, MINUS, QUOTE = "\N{NO-BREAK SPACE}", "\N{THIN SPACE}", "\N{MINUS SIGN}", "\u2019"


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("", []), ("a", ["a"]), ("a\n", ["a"]), ("\n", [""]), ("a\n\n", ["a", ""]),
        ("a\r\nb\rc\nd", ["a", "b", "c", "d"]),
        ("a\x0bb\x0cc\x85d\u2028e", ["a\x0bb\x0cc\x85d\u2028e"]),
    ],
)  # fmt: skip
def test_only_cr_and_lf_end_a_line(text, lines):
    assert lines_of(text) == lines


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ("ä;1".encode(), "ä;1"), ("ä;1".encode("cp1252"), "ä;1"), (b"\x81;1", "\ufffd;1"),
        ("ä;1".encode("utf-8-sig"), "ä;1"), ("\u0100;1\n".encode("utf-16-le"), "\u0100;1\n"),
        ("\u0100;1\n".encode("utf-16-be"), "\u0100;1\n"), (b"", ""), (b"1", "1"), (b"12", "12"),
    ],
)  # fmt: skip
def test_a_text_is_that_which_was_written(data, text):
    assert decode_text(data, "a.csv") == text


@pytest.mark.parametrize(
    ("data", "words", "line"),
    [
        (b"a;b\n1;2\n3\0;4", "binary data, no text", 3),
        (b"\0", "no UTF-16-BE text", 1),
        (b"a;b\0c;d\n1;2" * 3, "binary data, no text", 1),  # zeros in a third of the bytes
        (b"\n" * 4 + b"1\0002" * 40, "binary data, no text", 5),
        ("a;b\n1;2\n3;4\n".encode("utf-16")[:-1], "no UTF-16-LE text", 3),
        ("a;b\n1;2\n3;4\n".encode("utf-16-be")[:-1], "no UTF-16-BE text", 3),
        (b"\xfe\xff" + "a\nb\n".encode("utf-16-be") + b"\xd8", "no UTF-16-BE text", 3),
        ("a\nb\nc".encode("utf-32")[:-2], "no UTF-32-LE text", 3),
    ],
)
def test_what_is_no_text_is_refused_with_its_line(data, words, line):
    with pytest.raises(FlatplankError) as raised:
        decode_text(data, "a.csv")
    assert raised.value.where == f"a.csv, line {line}" and words in raised.value.what


NUMBERS = {
    "1": 1.0, " 1 ": 1.0, "-1": -1.0, "+1": 1.0, f"{MINUS}1": -1.0, "1.5": 1.5, "1.": 1.0,
    ".5": 0.5, "0.5": 0.5, "1e3": 1e3, "1E-3": 1e-3, "1.5d2": 150.0, "1D+2": 100.0, "007": 7.0,
    "1,234": 1234.0, "12,345,678.5": 12345678.5, "1'234.5": 1234.5, f"1{QUOTE}234": 1234.0,
    "1 234 567": 1234567.0, f"1{NBSP}234.5e1": 12345.0, f"1{THIN}234": 1234.0,
    "inf": math.inf, "-INF": -math.inf, "+Infinity": math.inf,
    "": math.nan, " NaN ": math.nan, "n/a": math.nan, "#N/A": math.nan, "NOTAVAIL": math.nan,
    "null": math.nan, "None": math.nan, "NA": math.nan,
}  # fmt: skip
TEXTS = ("x", "1x", "e5", ".", "-", "+", "1.2.3", "0,123", "1,23", "1234,567", "1,234'567",
         "1 23", "--1", "1e", "1e5.5", "0x10", "1_000", "infinite", "nano", "1,234,56",
         "1..5")  # fmt: skip


@pytest.mark.parametrize("text", NUMBERS)
def test_a_number_with_a_decimal_point(text):
    np.testing.assert_equal(number_of(text), NUMBERS[text])
    assert looks_like_number(text) == (not math.isnan(NUMBERS[text]))
    assert is_missing(text) == math.isnan(NUMBERS[text])


@pytest.mark.parametrize("text", NUMBERS)
def test_a_number_with_a_decimal_comma(text):
    turned = text.translate(str.maketrans(".,", ",."))
    np.testing.assert_equal(number_of(turned, COMMA), NUMBERS[text])


@pytest.mark.parametrize("text", TEXTS)
def test_other_text_is_no_number(text):
    assert number_of(text) is None and not is_missing(text)


@pytest.mark.parametrize("style", [POINT, COMMA], ids=["point", "comma"])
def test_the_cells_of_a_column_are_read_as_one_by_one(style):
    cells = [text.strip() for text in (*NUMBERS, *TEXTS)]
    values, other = numbers_of(pa.array(cells), style, "a.csv")
    alone = [number_of(cell, style) for cell in cells]
    np.testing.assert_array_equal(values, [np.nan if v is None else v for v in alone])
    np.testing.assert_array_equal(other, [v is None for v in alone])


@pytest.mark.parametrize(
    "cells",
    [["1", "2.5", "-3e2"], ["1,5", "2"], ["1,5", "x", ""], ["1.234,5", "1"], ["1,234.5", "nan"],
     ["1_000", "2"], ["1,5", "1,5", "0.5"], ["inf", "1d2"], ["NOTAVAIL", "1.2.3"], []],
)  # fmt: skip
def test_cells_without_arrow_are_read_as_a_column_with_it(cells):
    column = pa.array(cells, pa.string())
    values, other = cell_numbers(cells, "a.tdx")
    expected = numbers_of(column, styles_of({"": column})[""], "a.tdx")
    np.testing.assert_array_equal(values, expected[0])
    np.testing.assert_array_equal(other, expected[1])


def test_a_comma_that_may_be_either_is_refused_without_arrow_too():
    with pytest.raises(FlatplankError, match="may be 1.234 or 1234"):
        cell_numbers(["1,234", "2"], "a.tdx")


ALONE = {".": NumberStyle(".", POINT.groups[:-1]), ",": NumberStyle(",", COMMA.groups[:-1])}
"""without the other mark between thousands"""


@pytest.mark.parametrize(
    ("columns", "styles"),
    [
        ({"a": ["1", "2"]}, {"a": POINT}),
        ({"a": ["1.5", "2"]}, {"a": ALONE["."]}),
        ({"a": ["1,5", "2"]}, {"a": ALONE[","]}),
        ({"a": ["1,5", "2"], "b": ["3", "4"]}, {"a": ALONE[","], "b": COMMA}),
        ({"a": ["1,5", "2"], "b": ["1,234", "4"]}, {"a": ALONE[","], "b": COMMA}),
        ({"a": ["1.5", "2"], "b": ["1,234", "4"]}, {"a": ALONE["."], "b": POINT}),
        ({"a": ["1,234", "2"]}, {"a": None}),
        ({"a": ["1,234", "2"], "b": ["1", "2"]}, {"a": None, "b": POINT}),
        ({"a": ["1,234", "2"], "b": ["1,5", "0.5"]}, {"a": None, "b": None}),
        ({"a": ["1,5", "1,5", "0.5"]}, {"a": ALONE[","]}),
        ({"a": ["1.234,5", "1"]}, {"a": COMMA}),
        ({"a": ["1,234.5", "1"]}, {"a": POINT}),
        ({"a": ["1.234.567", "1"]}, {"a": COMMA}),
        ({"a": ["1,5"], "b": ["1.234,5"]}, {"a": COMMA, "b": COMMA}),
        ({"a": ["1,5"], "b": ["1.2.3"]}, {"a": ALONE[","], "b": COMMA}),
        ({"a": ["1,5"], "b": ["1.5", "2.5"]}, {"a": ALONE[","], "b": ALONE["."]}),
        ({"a": []}, {"a": POINT}),
    ],
)
def test_the_style_of_a_column(columns, styles):
    """By its own cells, else by those of the file; unknown where nothing decides."""
    assert styles_of({n: pa.array(c, pa.string()) for n, c in columns.items()}) == styles


def test_a_doubtful_number_is_quoted_with_both_values():
    with pytest.raises(FlatplankError) as raised:
        numbers_of(pa.array(["x,y", "12", "1,234", "5,678"]), None, "a.csv, column 'fx'")
    assert raised.value.what == "'1,234' may be 1.234 or 1234"
    assert raised.value.where == "a.csv, column 'fx'"


def test_cells_that_are_no_numbers_in_words():
    cells = NotNumbers(2, 40, "'OVL' in line 12")
    assert str(cells) == "2 of 40 cells are not numbers, first 'OVL' in line 12"


PLAIN = b"0123456789" * 10
PACKED = {
    "zstd": zstandard.ZstdCompressor(write_content_size=False).compress(PLAIN),
    "lz4": lz4.frame.compress(PLAIN),
    "bz2": bz2.compress(PLAIN),
}


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("size", [None, 100])
def test_a_part_is_unpacked_and_counted(kind, size):
    budget = Budget("a.bag", 250)
    unpack = getattr(budget, kind)
    assert unpack(PACKED[kind], size) == PLAIN and budget.left == 150
    assert unpack(PACKED[kind], size) == PLAIN and budget.left == 50
    with pytest.raises(FlatplankError, match=r"^a.bag: it unpacks to more than 1000 times"):
        unpack(PACKED[kind], size)


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize(("left", "whole"), [(99, False), (100, True)])
def test_the_last_byte_of_a_budget(kind, left, whole):
    budget = Budget("a.bag", left)
    if whole:
        assert getattr(budget, kind)(PACKED[kind]) == PLAIN and budget.left == 0
        budget.take(0)
    else:
        with pytest.raises(FlatplankError, match="unpacks to more"):
            getattr(budget, kind)(PACKED[kind])


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("size", [0, 99, 101])
def test_a_part_of_another_size_is_damaged(kind, size):
    with pytest.raises(DamagedError, match="does not unpack to its size"):
        getattr(Budget("a.bag", 1000), kind)(PACKED[kind], size)


@pytest.mark.parametrize("kind", PACKED)
def test_a_part_that_is_cut_or_no_such_part_is_damaged(kind):
    unpack = getattr(Budget("a.bag", 1000), kind)
    with pytest.raises(DamagedError):
        unpack(PACKED[kind][:-6], 100)
    with pytest.raises(DamagedError, match=f"^{kind}: "):
        unpack(b"no packed part of a file", 100)


def test_pieces_have_a_largest_size(monkeypatch):
    monkeypatch.setattr(guard, "PIECE", 99)
    with pytest.raises(FlatplankError, match="unpacks to more"):
        Budget("a.bag", 1000).zstd(PACKED["zstd"])
    monkeypatch.setattr(guard, "PIECE", 100)
    assert Budget("a.bag", 1000).zstd(PACKED["zstd"]) == PLAIN


@pytest.mark.parametrize(
    ("stored", "left"), [(0, 1 << 28), (1000, 1 << 28), (268436, 268_436_000)]
)
def test_a_file_may_unpack_to_a_thousand_times_its_size_or_a_quarter_gigabyte(stored, left):
    assert Budget.of("a.bag", stored) == Budget("a.bag", left)
