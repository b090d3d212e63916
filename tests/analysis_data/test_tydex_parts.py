# SPDX-License-Identifier: Apache-2.0
"""TYDEX field by field: what is read from a line, and what is written to it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.readers.tydex import CHANNELS, CONSTANTS, read_tydex
from flatplank_data.store import LocalStore
from flatplank_data.table import COLUMN_UNITS
from flatplank_tire.tydex import Channel, Quantity, TydexFile, format_tydex, parse_tydex


def line(name: str, note: str = "", unit: str = "", rest: str = "") -> str:
    """Fields of 10, 30 and 10 characters, then the rest."""
    return f"{name:<10}{note:<30}{unit:<10}{rest}"


def text(channels=("FX", "FZ"), data=("1 2",), before=(), head=(), end="**END\n") -> str:
    """A file with channels in newtons, or with their whole lines."""
    lines = [c if len(c) > 10 else line(c, "", "N") for c in channels]
    parts = ["**HEADER", *head, *before, "**MEASURCHANNELS", *lines, "**MEASURDATA", *data, end]
    return "\n".join(parts)


def error_of(content: str) -> FlatplankError:
    with pytest.raises(FlatplankError) as raised:
        parse_tydex(content, "a.tdx")
    return raised.value


def test_the_fields_of_header_comments_and_constants():
    head = [line("release", "Release of the format", "1.3"), "short", "! line"]
    before = [
        "**COMMENTS",
        "! none",
        "first",
        "",
        "second",
        "**CONSTANTS",
        line("fzw", "vertical force", "kN", "3.7"),
        line("NOTE", "", "", "two words"),
    ]
    file = parse_tydex(text(before=before, head=head), "a.tdx")
    assert file.header == {"RELEASE": "1.3", "SHORT": ""}
    assert list(file.comments) == ["first", "second"]
    assert file.constants == {
        "FZW": Quantity("kN", "3.7", "vertical force"), "NOTE": Quantity("", "two words", ""),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("rest", "scale"),
    [("", (1.0, 0.0, 0.0)), ("2", (2.0, 0.0, 0.0)), ("2 3", (2.0, 3.0, 0.0)),
     ("2 3 4", (2.0, 3.0, 4.0)), ("0,5 -1 1e3 five", (0.5, -1.0, 1e3))],
)  # fmt: skip
def test_a_channel_has_a_factor_and_two_offsets(rest, scale):
    factor, before, after = scale
    rest = rest.replace(",", ".")
    file = parse_tydex(text([line("fx", "along", "kN", rest)], ["10", "-20"]), "a.tdx")
    assert list(file.channels) == [Channel("FX", "kN", factor, before, after, "along")]
    np.testing.assert_allclose(file.data[:, 0], [factor * (v + before) + after for v in (10, -20)])


def test_every_channel_is_scaled_by_its_own_factor_and_offsets():
    channels = [line("FX", "", "N", "2 1 5"), line("FZ", "", "N", "3 -1 7")]
    file = parse_tydex(text(channels, ["1 2", "3 4"]), "a.tdx")
    np.testing.assert_array_equal(file.data, [[9.0, 10.0], [13.0, 16.0]])


@pytest.mark.parametrize(
    ("data", "rows"),
    [
        (["1 2", "3 4"], [[1, 2], [3, 4]]), (["1", "2 3", "4"], [[1, 2], [3, 4]]),
        (["1 2 3 4"], [[1, 2], [3, 4]]), (["", "! 9 9", "1 2"], [[1, 2]]),
        (["1\t2"], [[1, 2]]), ([" 1.2345678-2.3456789"], [[1.2345678, -2.3456789]]),
        (["-12.45678 1234567.5"], [[-12.45678, 1234567.5]]), (["1,5 2"], [[1.5, 2.0]]),
        ([" 12345.678-2345.6789", "         1         2"], [[12345.678, -2345.6789], [1, 2]]),
        (["1 2", "**END", "3"], [[1, 2]]),
    ],
)  # fmt: skip
def test_the_samples_of_two_channels(data, rows):
    """With blanks between them, or ten characters each; a sample may span lines."""
    np.testing.assert_allclose(parse_tydex(text(data=data), "a.tdx").data, rows)


def test_cells_that_are_no_numbers_are_counted_by_channel():
    file = parse_tydex(text(data=["1 x", "2 3", "NOTAVAIL y z", "5"]), "a.tdx")
    np.testing.assert_array_equal(file.data, [[1, np.nan], [2, 3], [np.nan] * 2, [np.nan, 5]])
    told = {name: str(cells) for name, cells in file.not_numbers.items()}
    assert told == {
        "FX": "1 of 4 cells are not numbers, first 'z' in line 8",
        "FZ": "2 of 4 cells are not numbers, first 'x' in line 6",
    }


@pytest.mark.parametrize(
    ("content", "what", "where"),
    [
        (text().replace("**HEADER", "**COMMENTS"), "no **HEADER", "a.tdx"),
        (text(end=""), "no **END: the file is cut short", "a.tdx"),
        (text(before=["**NOTHING x"]), "unknown keyword **NOTHING", "a.tdx, line 2"),
        (text([line("FX"), "FZ"]), "channel FX has no unit", "a.tdx, line 3"),
        (text(["FX", line("FZ", "", "N", "two 3 4 5")]), "channel FZ: 'two 3 4 5' is no factor",
         "a.tdx, line 4"),
        (text(["FX", line("FZ", "", "N", "2 3 x")]), "channel FZ: '2 3 x' is no factor",
         "a.tdx, line 4"),
        (text(["FX", "FZ", "FX"]), "channel FX twice", "a.tdx"),
        (text([]), "no channels", "a.tdx"),
        (text(data=[]), "no samples", "a.tdx, sample 1, line 0"),
        (text(data=["1 2", "3"]), "1 of 2 values", "a.tdx, sample 2, line 7"),
        (text(["FX", "FZ", "FY"], ["1 2 3", "4 5"]), "2 of 3 values",
         "a.tdx, sample 2, line 8"),
        (text(before=["**CONSTANTS", line("FZW", "", "N", "1"), line("fzw", "", "N", "2")]),
         "constant FZW twice", "a.tdx, line 4"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_file_and_where(content, what, where):
    error = error_of(content)
    assert (error.what, error.where) == (what, where) and error.remedy


def test_a_keyword_may_have_words_behind_it_and_small_letters():
    content = text(data=["1 2"]).replace("**MEASURDATA", "**MeasurData of today")
    np.testing.assert_array_equal(parse_tydex(content, "a.tdx").data, [[1.0, 2.0]])


NINE = {
    0.0: "0", 1.0: "1", -1.5: "-1.5", 123456789.0: "123456789", -123456789.0: "-1.2346e8",
    1234567891.0: "1.23457e9", math.pi: "3.1415927", -math.pi: "-3.141593", 1e-7: "1e-7",
    1.2345678e-7: "1.2346e-7", -1.2345678e-12: "-1.23e-12", 1e22: "1e+22", 0.1: "0.1",
    math.nan: "NOTAVAIL", math.inf: "NOTAVAIL", -1.23456e-100: "-1.2e-100",
    -1.26e300: "-1.3e+300", 123456.789: "123456.79",
}  # fmt: skip


@pytest.mark.parametrize("value", NINE)
def test_a_number_takes_at_most_nine_characters(value):
    """As many digits as there is room for; both columns are ten wide."""
    channels = (Channel("FX", "N"), Channel("FZ", "N"))
    content = format_tydex(TydexFile(channels=channels, data=np.array([[value, 1.0]])))
    (sample,) = content.split("**MEASURDATA\n")[1].split("\n**END\n")[0].split("\n")
    assert sample == f"{NINE[value]:>9} {'1':>9}"


def test_a_file_is_written_in_fields_of_fixed_width():
    file = TydexFile(
        {"RELEASE": "1.3", "A_LONG_NAME": "x y"}, ["one", "two"],
        {"FZW": Quantity("N", "3700", "fz"),
         "LONG_CONSTANT": Quantity("a long unit", "1", "n" * 40)},
        (Channel("FX", "N", 5.0, 6.0, 7.0, "along"),
         Channel("LONG_CHANNEL", "u" * 12, note="m" * 40)),
        np.array([[1.0, 2.0], [-3.0, np.nan]]),
    )  # fmt: skip
    assert format_tydex(file).split("\n") == [
        "**HEADER", "RELEASE" + " " * 33 + "1.3", "A_LONG_NAM" + " " * 30 + "x y",
        "**COMMENTS", "one", "two", "**CONSTANTS",
        "FZW       fz" + " " * 28 + "N" + " " * 9 + "3700",
        "LONG_CONS " + "n" * 29 + " a long un 1",
        "**MEASURCHANNELS",
        "FX        along" + " " * 25 + "N" + " " * 9 + "1         0         0",
        "LONG_CHAN " + "m" * 29 + " " + "u" * 9 + " 1         0         0",
        "**MEASURDATA", "        1         2", "       -3  NOTAVAIL", "**END", "",
    ]  # fmt: skip


def read(folder, content: str, **options) -> Loaded:
    (folder / "a.tdx").write_text(content)
    return read_tydex(Request(LocalStore(str(folder)), "a.tdx", **options))


@pytest.mark.parametrize("channel", CHANNELS)
def test_every_channel_fills_its_column(tmp_path, channel):
    ours = CHANNELS[channel]
    unit = {"1": "-"}.get(COLUMN_UNITS[ours], COLUMN_UNITS[ours])
    loaded = read(tmp_path, text([line(channel, "", unit)], ["5", "6"]))
    np.testing.assert_array_equal(loaded.columns[ours], [5.0, 6.0])
    assert len(loaded.columns) == 1 and not loaded.remarks


def test_unknown_channels_are_told_and_mapped_ones_are_read(tmp_path):
    content = text(["FX", "FYH", "OWN"], ["1 2 3"])
    loaded = read(tmp_path, content)
    assert list(loaded.remarks) == [
        "channel 'FYH' is not known and was left out (C and H axes are not turned to W)",
        "channel 'OWN' is not known and was left out",
    ]
    for ours, columns in (("fz", {"fx", "fz"}), ("fzz", {"fx"}), (["fz"], {"fx"})):
        loaded = read(tmp_path, content, mapping={"columns": {"OWN": ours}})
        assert set(loaded.columns) == columns
    assert set(read(tmp_path, content, columns=["fz"]).columns) == set()


def test_two_channels_of_one_column_are_refused(tmp_path):
    with pytest.raises(FlatplankError) as raised:
        read(tmp_path, text(["FX", "FXW"]))
    assert (raised.value.what, raised.value.where) == ("two channels give 'fx'", "a.tdx, FXW")


CONSTANT = {
    "LONGSLIP": ("%", "5", 0.05), "FZW": ("kN", "3.7", 3700.0), "INFLPRES": ("kPa", "250", 2.5),
    "SLIPANGL": ("rad", "0.1", 18.0 / math.pi), "INCLANGL": ("deg", "-2", -2.0),
    "LONGVEL": ("mm/s", "31", 0.031), "EFFROLRA": ("mm", "311", 0.311),
    "STEPPOS": ("cm", "150", 1.5), "STARTPOS": ("-", "2.0", 2), "RUNINDEX": ("", "7.4", 7),
}  # fmt: skip


@pytest.mark.parametrize("key", CONSTANTS)
def test_every_constant_fills_its_key(tmp_path, key):
    unit, written, value = CONSTANT[key]
    before = ["**CONSTANTS", line(key, "", unit, written), line("OTHER", "", "N", "x")]
    loaded = read(tmp_path, text(before=before))
    ((ours, found),) = loaded.facts.items()
    assert (ours, found) == (CONSTANTS[key][0], pytest.approx(value))
    assert type(found) is type(value)


def test_an_empty_constant_is_not_known_and_a_word_is_refused(tmp_path):
    before = ["**CONSTANTS", line("FZW", "", "N", ""), line("SLIPANGL", "", "", "0.1")]
    assert read(tmp_path, text(before=before)).facts == {"alpha_deg": pytest.approx(5.729578)}
    with pytest.raises(FlatplankError) as raised:
        read(tmp_path, text(before=["**CONSTANTS", line("FZW", "", "N", "heavy")]))
    assert raised.value.what == "'heavy' is not a number"
    assert raised.value.where == "a.tdx, constant FZW"


def test_date_and_supplier_are_those_of_the_header(tmp_path):
    head = [line("DATE", "", "03-May"), line("SUPPLIER", "", "lab"), line("MEASID", "", "7")]
    assert read(tmp_path, text(head=head)).facts == {"date": "03-May", "operator": "lab"}
    assert read(tmp_path, text(head=[line("DATE", "", "")])).facts == {}
