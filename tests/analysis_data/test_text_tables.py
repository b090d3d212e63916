# SPDX-License-Identifier: Apache-2.0
"""Text tables as people and programs write them give the values that pandas reads."""

from __future__ import annotations

import io
import itertools

import numpy as np
import pandas as pd
import pytest

from flatplank_data.campaign import Campaign
from flatplank_data.delimited import read_text_table
from flatplank_data.errors import FlatplankError
from flatplank_validation.trust.files.text import NAMES, ROWS, STYLES, written

ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252")


def by_pandas(text: str, separator: str, style: str, **options) -> pd.DataFrame:
    decimal, thousands, _ = STYLES[style]
    if not thousands.isascii():  # pandas knows only ASCII
        text, thousands = text.replace(thousands, ""), ""
    return pd.read_csv(
        io.StringIO(text), sep=separator, decimal=decimal, thousands=thousands or None, **options
    )


CASES = [(style, mark) for style, (_, _, marks) in STYLES.items() for mark in marks]


@pytest.mark.parametrize(("style", "separator"), CASES)
def test_every_separator_and_style_is_read_as_by_pandas(style, separator):
    text = written(separator, style)
    expected = by_pandas(text, separator, style)
    assert np.allclose(expected.to_numpy(float), ROWS, atol=1e-4)
    for encoding in ENCODINGS:
        table = read_text_table(text.encode(encoding), "a.csv")
        assert table.names == NAMES and not table.remarks
        for name in NAMES:
            values, other = table.column(name)
            np.testing.assert_array_equal(values, expected[name].to_numpy())
            assert not other.any()


@pytest.mark.parametrize(
    "head",
    [
        ["time [s];plank_position [mm];fx [kN];fz [lb]"],
        ["time (s);plank_position (mm);fx (kN);fz (lb)"],
        ["time / s;plank_position / mm;fx / kN;fz / lb"],
        ["time;plank_position;fx;fz", "s;mm;kN;lb"],
        ["time;plank_position;fx;fz", "[s];[mm];[kN];[lb]"],
        ["Prüfstand 3", "# made up", "", "time;plank_position;fx;fz", "s;mm;kN;lb"],
        ["sep=;", "time;plank_position;fx;fz", "running time;way;force;load", "s;mm;kN;lb"],
    ],
)
def test_names_and_units_are_found_wherever_they_stand(head):
    text = written(";", "comma", head=head)
    known = NAMES.__contains__
    for encoding in ("utf-8", "cp1252", "utf-16"):
        table = read_text_table(text.encode(encoding), "a.csv", known)
        assert table.names == NAMES
        units = {name: unit.strip("[]") for name, unit in table.units.items()}
        assert units == dict(zip(NAMES, ["s", "mm", "kN", "lb"], strict=True))
        np.testing.assert_allclose(table.column("fz").values, ROWS[:, 3], atol=1e-4)


def test_a_lone_comma_is_doubted_unless_the_file_decides():
    doubtful = "time;fx\n" + "".join(f"{k};1,{k:03d}\n" for k in range(100, 140))
    with pytest.raises(FlatplankError, match=r"column 'fx': '1,100' may be 1.100 or 1100"):
        read_text_table(doubtful.encode(), "a.csv").column("fx")
    decided = doubtful.replace("100;1,100", "100,5;1,100")
    assert read_text_table(decided.encode(), "a.csv").column("fx").values[0] == 1.1
    other_way = doubtful.replace("100;1,100", "100.5;1,100")
    assert read_text_table(other_way.encode(), "a.csv").column("fx").values[0] == 1100.0


@pytest.mark.parametrize(
    ("text", "value"),
    [("1.5D3", 1500.0), ("-2,5e-1", -0.25), ("\N{MINUS SIGN}3", -3.0), ("+4", 4.0), (".5", 0.5),
     ("7.", 7.0), ("inf", np.inf), ("-Infinity", -np.inf)],
)  # fmt: skip
def test_numbers_of_other_programs(text, value):
    table = read_text_table(f"a;b\n{text};2\n{text};3\n".encode(), "a.csv")
    assert list(table.column("a").values) == [value, value]


@pytest.mark.parametrize("text", ["", "nan", "NaN", "NA", "n/a", "NULL", "NOTAVAIL"])
def test_words_for_no_value_are_no_text(text):
    table = read_text_table(f"a;b\n1;{text}\n2;3\n".encode(), "a.csv")
    values, other = table.column("b")
    assert np.isnan(values[0]) and values[1] == 3.0 and not other.any()


@pytest.mark.parametrize("text", ["OVL", "--", "1_000", "0x10", "1.2.3", "1,2,3", "1'23", "e5"])
def test_other_text_is_counted_and_quoted(text):
    table = read_text_table(f"a;b\n0.5;1\n2;{text}\n3;{text}\n".encode(), "a.csv")
    values, other = table.column("b")
    assert list(np.isnan(values)) == list(other) == [False, True, True]
    assert table.first("b", other) == f"'{text}' in line 3"


def test_lines_that_are_no_samples_are_counted_and_quoted():
    text = written(";", "comma").splitlines()
    text[10:10] = ["Pause", "# 12;13;14;15"]
    text[30:30] = [text[0]]
    table = read_text_table("\n".join(text).encode(), "a.csv")
    assert table.remarks == ["3 lines are no samples and were left out: line 11 'Pause'"]
    np.testing.assert_allclose(table.column("fx").values, ROWS[:, 2], atol=1e-4)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no line of numbers"),
        (b"time;fx\n", "no line of numbers"),
        (b"1;2\n3;4\n", "no header of 2 names before line 1"),
        (b"a;b\n1;2\n3\n4;5\n", "line 3: 1 values for 2 columns"),
        (b"a;b\n1;2\n3;4;5\n", "line 3: 3 values for 2 columns"),
        (b"a;b\n1;2\n\x00\x01\x02;3\n", "line 3: binary data"),
        ("a;b\n1;2\n".encode("utf-16")[:-1], "cut short or damaged"),
        (bytes(range(256)), "binary data"),
    ],
)
def test_what_is_no_table_is_refused_in_one_line(data, words):
    with pytest.raises(FlatplankError, match=words) as caught:
        read_text_table(data, "a.csv")
    assert "a.csv" in str(caught.value) and "\n" not in str(caught.value)


ENTRY = "{file: r.csv, kappa: 0.05, fz: 3700, start: 1, measurement: locked_wheel}"


def a_campaign(folder, text: str | bytes, entry: str = ENTRY) -> Campaign:
    """A campaign of one run, read."""
    data = text if isinstance(text, bytes) else text.encode()
    (folder / "r.csv").write_bytes(data)
    (folder / "campaign.yaml").write_text(
        f"format: flatplank-measurement-table/1\ntire: TOY\nruns: [{entry}]\n"
    )
    return Campaign.load(folder)


def _problems(campaign: Campaign) -> str:
    assert list(campaign.tables()) == [] or campaign.problems
    return "\n".join(map(str, campaign.problems))


def test_a_column_that_nobody_needs_costs_nothing(tmp_path):
    table = pd.DataFrame(ROWS, columns=NAMES).assign(stamp="2024-05-01T10:00", mz="OVL", note="x")
    campaign = a_campaign(tmp_path, table.to_csv(index=False))
    (found,) = campaign.tables()
    np.testing.assert_array_equal(found["fx"], table["fx"])
    told = _problems(campaign)
    assert "column 'stamp' is not known and was left out" in told
    assert "column 'mz': 40 of 40 cells are not numbers, first 'OVL' in line 2" in told


def test_text_in_a_needed_column_is_quoted_with_its_line(tmp_path):
    table = pd.DataFrame(ROWS, columns=NAMES).astype(object)
    table.loc[7, "fx"] = "OVL"
    campaign = a_campaign(tmp_path, table.to_csv(index=False))
    assert not list(campaign.tables())
    (problem,) = campaign.problems
    assert "line 9: 'OVL' in column 'fx' is not a number" in str(problem)


@pytest.mark.parametrize(
    "stamps",
    [
        [f"2024-05-01T10:00:{s:06.3f}" for s in ROWS[:, 0]],
        [f"2024-05-01 10:00:{s:06.3f}+02:00" for s in ROWS[:, 0]],
        [f"2024-05-01T10:00:{s:09.6f}Z" for s in ROWS[:, 0]],
        [f"10:00:{s:06.3f}".replace(".", ",") for s in ROWS[:, 0]],
    ],
    ids=["local", "zone", "utc", "time of day"],
)
def test_stamps_are_seconds_since_the_first(tmp_path, stamps):
    table = pd.DataFrame(ROWS, columns=NAMES).assign(time=stamps)
    (found,) = a_campaign(tmp_path, table.to_csv(index=False, sep=";")).tables()
    expected = pd.to_datetime(pd.Series(stamps).str.replace(",", "."), format="mixed")
    seconds = (expected - expected[0]).dt.total_seconds()
    np.testing.assert_allclose(found["time"], seconds, atol=1e-6)


def test_rows_of_one_clock_are_sorted_and_two_recordings_are_refused(tmp_path):
    table = pd.DataFrame(ROWS, columns=NAMES)
    mixed = table.sample(frac=1.0, random_state=3)
    campaign = a_campaign(tmp_path, mixed.to_csv(index=False))
    (found,) = campaign.tables()
    np.testing.assert_array_equal(found["fx"], table["fx"])
    assert "rows are not in order of time" in _problems(campaign)
    later = table.assign(time=table["time"] + 0.02)
    campaign = a_campaign(tmp_path, pd.concat([table, later]).to_csv(index=False))
    assert not list(campaign.tables())
    assert "row 41: time does not increase: 0.02 s after 1.95 s" in _problems(campaign)


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (np.zeros(40), "all stamps are 0 s"),
        (np.round(ROWS[:, 0], 1), "stamps are repeated"),
        (ROWS[::-1, 0], "time does not increase"),
    ],
)
def test_stamps_that_do_not_tell_the_order_are_refused(tmp_path, time, words):
    table = pd.DataFrame(ROWS, columns=NAMES).assign(time=time)
    campaign = a_campaign(tmp_path, table.to_csv(index=False))
    assert not list(campaign.tables()) and words in _problems(campaign)


def test_time_that_is_neither_a_number_nor_a_date_is_refused(tmp_path):
    table = pd.DataFrame(ROWS, columns=NAMES).assign(time="yesterday")
    campaign = a_campaign(
        tmp_path, table.to_csv(index=False), ENTRY.replace("locked_wheel", "slip")
    )
    assert not list(campaign.tables())
    assert "line 2: 'yesterday' is neither a number nor a stamp" in _problems(campaign)


def test_text_of_any_kind_is_text_to_the_decoder():
    text = "Größe;°C\n" + "1,5;2,5\n" * 3
    for encoding, end in itertools.product(ENCODINGS, ("\n", "\r\n", "\r")):
        table = read_text_table(text.replace("\n", end).encode(encoding), "a.csv")
        assert table.names == ["Größe", "°C"] and len(table.lines) == 3


@pytest.mark.parametrize("units", [[], ["s;m;N;N"]], ids=["no units", "units"])
def test_a_damaged_line_before_the_first_sample_is_not_lost(units):
    """It belongs neither to the names nor to the units."""
    head = ["Run 7", ";".join(NAMES), *units]
    whole = written(";", "comma", head=head)
    cut = whole.replace("0,0000;0,0000;", "0,0000;0,0000&", 1)
    with pytest.raises(FlatplankError, match=f"line {len(head) + 1}: 3 values for 4 columns"):
        read_text_table(cut.encode(), "a.csv", NAMES.__contains__)
    lines = [*head, "# a comment", "started again by hand"]
    table = read_text_table(
        written(";", "comma", head=lines).encode(), "a.csv", NAMES.__contains__
    )
    assert len(table.lines) == len(ROWS)
    place = f"line {len(lines)} 'started again by hand'"
    assert table.remarks == [f"1 line is no sample and was left out: {place}"]
