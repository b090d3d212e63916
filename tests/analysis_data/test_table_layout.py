# SPDX-License-Identifier: Apache-2.0
"""Where names, units and samples of a text table are found, line by line."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_data.delimited import TextTable, read_text_table, split_cells, split_header
from flatplank_data.errors import FlatplankError


def read(text: str, *known: str) -> TextTable:
    return read_text_table(text.encode(), "a.csv", known.__contains__)


def error_of(text: str, *known: str) -> FlatplankError:
    with pytest.raises(FlatplankError) as raised:
        read(text, *known)
    return raised.value


@pytest.mark.parametrize(
    ("line", "separator", "cells"),
    [
        (" a ; b;c ", ";", ["a", "b", "c"]), ("a;;", ";", ["a", "", ""]),
        ("  1   2 ", " ", ["1", "2"]), ("a\t b", "\t", ["a", "b"]),
        ('"a;b";c', ";", ["a;b", "c"]), ('1; "2;5" ;3', ";", ["1", "2;5", "3"]),
        ('"run time" 1', " ", ["run time", "1"]), ('"a ""b""",c', ",", ['a "b"', "c"]),
        ("a", ",", ["a"]), ("", ";", [""]), (" ", " ", []),
    ],
)  # fmt: skip
def test_the_cells_of_a_line(line, separator, cells):
    assert split_cells(line, separator) == cells


@pytest.mark.parametrize(
    ("cell", "name", "unit"),
    [
        ("fx", "fx", ""), ("fx [N]", "fx", "N"), (" fx[N] ", "fx", "N"), ("fx []", "fx", "-"),
        ("fx [ ]", "fx", "-"), ("fx (kN)", "fx", "kN"), ("fx ()", "fx", "-"),
        ("fx / N", "fx", "N"), ("way / turn", "way", "turn"), ("load / side", "load / side", ""),
        ("fx/N", "fx/N", ""), ("fx [bar (g)]", "fx", "bar (g)"), ("f(x) [N]", "f(x)", "N"),
        ("[N]", "", "N"), ("fx [N] x", "fx [N] x", ""),
    ],
)  # fmt: skip
def test_the_name_and_the_unit_in_a_cell(cell, name, unit):
    assert split_header([cell]) == ([name], [unit])


@pytest.mark.parametrize(
    ("text", "names", "units", "lines", "first"),
    [
        # the separator that most lines of numbers have, the earlier one where two are as good
        ("a;b\n1,5;2,5\n3,5;4,5\n", ["a", "b"], {}, [2, 3], 1.5),
        ("a,b\n1,2\n3,4\n", ["a", "b"], {}, [2, 3], 1.0),
        ("a|b\n1|2\n", ["a", "b"], {}, [2], 1.0),
        ("a b\n1 2\n", ["a", "b"], {}, [2], 1.0),
        ("a\tb c\n1\t2\n", ["a", "b c"], {}, [2], 1.0),
        # lines before the names
        ("Run 7\na;b\n1;2\n", ["a", "b"], {}, [3], 1.0),
        ("# a;b\nc;d\n1;2\n", ["c", "d"], {}, [3], 1.0),
        ("% x\n! y\n// z\na;b\n1;2\n", ["a", "b"], {}, [5], 1.0),
        ("\n\na;b\n\n1;2\n\n", ["a", "b"], {}, [5], 1.0),
        ("a;b;c\nd;e\n1;2\n3;4\n", ["d", "e"], {}, [3, 4], 1.0),
        # units
        ("a [m];b\n1;2\n", ["a", "b"], {"a": "m"}, [2], 1.0),
        ("a;b\nm;1\n1;2\n", ["a", "b"], {"a": "m", "b": "1"}, [3], 1.0),
        ("a;b\nm;\n1;2\n", ["a", "b"], {"a": "m"}, [3], 1.0),
        ("a;b\nway;load\nm;N\n1;2\n", ["way", "load"], {"way": "m", "load": "N"}, [4], 1.0),
        ("a;b\nway;load\n1;2\n", ["way", "load"], {}, [3], 1.0),
        ("a;b\n1;1\n1;2\n", ["a", "b"], {}, [2, 3], 1.0),
        # one column more or less
        ("a;b\n1;2;\n3;4;\n", ["a", "b", "column 3"], {}, [2, 3], 1.0),
        ("a;b;\n1;2\n3;4\n", ["a", "b"], {}, [2, 3], 1.0),
        ("a;b;;\n1;2\n3;4\n", ["a", "b"], {}, [2, 3], 1.0),
        ("a;;c\n1;2;3\n", ["a", "column 2", "c"], {}, [2], 1.0),
        ("a;x;x;x\n1;2;3;4\n", ["a", "x", "x (2)", "x (3)"], {}, [2], 1.0),
        # an empty cell and a word for none belong to a sample
        ("a;b\n;2\n1;2\nnan;\n", ["a", "b"], {}, [2, 3, 4], np.nan),
    ],
)  # fmt: skip
def test_names_units_and_samples(text, names, units, lines, first):
    table = read(text)
    assert (list(table.names), dict(table.units)) == (names, units)
    assert list(table.lines) == lines and list(table.remarks) == []
    np.testing.assert_equal(table.column(names[0]).values[0], first)


@pytest.mark.parametrize(
    ("text", "names", "units"),
    [
        # the line with the most known names is that of the names, the first of them
        ("fx;fz\nforce;load\nN;N\n1;2\n", ["fx", "fz"], {"fx": "N", "fz": "N"}),
        ("fx;fz\nforce;load\n1;2\n", ["fx", "fz"], {"fx": "force", "fz": "load"}),
        ("force;load\nfx;fz\n1;2\n", ["fx", "fz"], {}),
        ("force;fz\nfx;fz\n1;2\n", ["fx", "fz"], {}),
        ("fx;fz\nfx;fz\n1;2\n", ["fx", "fz"], {"fx": "fx", "fz": "fz"}),
        ("m;N\nfx;fz\n1;2\n", ["fx", "fz"], {}),
        ("fx [kN];fz\nforce;load\n1;2\n", ["fx", "fz"], {"fx": "kN"}),
        ("m;N\nfx;fz\nkN;kN\n1;2\n", ["fx", "fz"], {"fx": "kN", "fz": "kN"}),
        ("fx;fz\nkN;kN\nforce;load\n1;2\n", ["fx", "fz"], {"fx": "kN", "fz": "kN"}),
    ],
)
def test_known_names_are_preferred(text, names, units):
    table = read(text, "fx", "fz")
    assert (list(table.names), dict(table.units)) == (names, units)


@pytest.mark.parametrize(
    ("text", "remark"),
    [
        ("a;b\n1;2\nend\n", "1 line is no sample and was left out: line 3 'end'"),
        ("a;b\n1;2\n# 3;4\nx;y\n", "2 lines are no samples and were left out: line 3 '# 3;4'"),
        (f"a;b\n1;2\n{'x' * 40}\n", f"1 line is no sample and was left out: line 3 '{'x' * 40}'"),
        (f"a;b\n1;2\n{'x' * 41}\n",
         f"1 line is no sample and was left out: line 3 '{'x' * 40} ...'"),
        ("a;b\n1;2\nan   end\n", "1 line is no sample and was left out: line 3 'an end'"),
    ],
)  # fmt: skip
def test_a_line_that_is_no_sample_is_told(text, remark):
    table = read(text)
    assert list(table.remarks) == [remark] and list(table.lines) == [2]


@pytest.mark.parametrize(
    ("text", "what", "where"),
    [
        ("a;b\nc;d\n", "no line of numbers", "a.csv"),
        ("1\n2\n", "no line of numbers", "a.csv"),
        ("# 1;2\n", "no line of numbers", "a.csv"),
        ("1;2;3\n", "no header of 3 names before line 1", "a.csv"),
        ("\nx\n1;2\n", "no header of 2 names before line 3", "a.csv"),
        ("a;b;c\n1;2\n", "no header of 2 names before line 2", "a.csv"),
        ("a;b;c;d\n1;2;3\n", "no header of 3 names before line 2", "a.csv"),
        ("a;b\n1;2;3\n", "no header of 3 names before line 2", "a.csv"),
        ("a;b\n1;2\n3;4\n5\n", "1 values for 2 columns (cut short?)", "a.csv, line 4"),
        ("a;b\n1;2\n3;4\n5;6;7\n", "3 values for 2 columns (cut short?)", "a.csv, line 4"),
        ("fx;fx\n1;2\n", "two columns 'fx'", "a.csv"),
    ],
)
def test_what_is_no_table_is_refused_with_its_place(text, what, where):
    error = error_of(text, "fx")
    assert (error.what, error.where) == (what, where) and error.remedy


def test_the_width_of_most_lines_counts():
    """Two lines of numbers among the titles are no samples of this table."""
    text = "7;8;9\na;b\n1;2\n3;4\n5;6\n"
    table = read(text)
    assert list(table.names) == ["a", "b"] and list(table.lines) == [3, 4, 5]
    far = "a;b\n" + "# 1,2\n" * 399 + "1;2\n"
    assert error_of(far).what == "no line of numbers"
    assert list(read(far.replace("# 1,2\n", "", 1)).lines) == [400]


def test_a_separator_is_judged_by_the_share_of_its_lines():
    """A comma parts two of four lines of numbers, the blank all of them."""
    text = "a b\n1,5 2\n3 4,5\n5 6\n7 8\n"
    table = read(text)
    assert list(table.names) == ["a", "b"]
    np.testing.assert_array_equal(table.column("b").values, [2.0, 4.5, 6.0, 8.0])


@pytest.mark.parametrize(
    ("cells", "seconds"),
    [
        (["0", "0.5", "1"], [0.0, 0.5, 1.0]), (["5", "", "7"], [5.0, np.nan, 7.0]),
        (["10:00:00", "10:00:01.5", "10:01:00"], [0.0, 1.5, 60.0]),
        (["", "10:00:00", "10:00:02"], [np.nan, 0.0, 2.0]),
    ],
)  # fmt: skip
def test_times_are_numbers_or_stamps(cells, seconds):
    table = read("time;b\n" + "".join(f"{cell};1\n" for cell in cells))
    np.testing.assert_allclose(table.time("time"), seconds)


def test_a_stamp_below_numbers_is_quoted_with_its_line():
    with pytest.raises(FlatplankError) as raised:
        read("time;b\n1;1\n2;1\n10:00:00;1\n").time("time")
    error = raised.value
    assert error.what == "'10:00:00' in line 4 is not a number as those above"
    assert error.where == "a.csv, column 'time'"


def test_cells_that_are_no_numbers_are_counted_and_the_first_is_quoted():
    table = read("a;b\n1;2\n1;\n1;OVL\n1;off\n")
    values, other = table.column("b")
    np.testing.assert_array_equal(values, [2.0, np.nan, np.nan, np.nan])
    assert list(other) == [False, False, True, True]
    cells = table.not_numbers("b", other)
    assert (cells.count, cells.rows, cells.first) == (2, 4, "'OVL' in line 4")
    assert table.first("b", np.isnan(values)) == "empty cell in line 3"
