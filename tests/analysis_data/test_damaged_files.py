# SPDX-License-Identifier: Apache-2.0
"""A thousand damaged files per reader, and the judges of `bench-trust`, which have to notice."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from test_text_tables import a_campaign

from flatplank_data.delimited import TextTable
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import Loaded
from flatplank_tire.text import lines_of
from flatplank_tire.tydex import parse_tydex
from flatplank_validation.trust.files import text
from flatplank_validation.trust.files.judge import by_numpy, judged
from flatplank_validation.trust.files.text_damage import damaged
from flatplank_validation.trust.registry import Options, rows
from flatplank_validation.trust.rows import bag_files, table_files

READERS = (
    "text", "tydex", "tir", "parquet", "matlab", "matlab73", "mcap", "sqlite", "ros1", "esi",
)  # fmt: skip
LEAST = 1000
"""damaged files per reader"""


@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_read_as_by_another_reader_or_refused(name):
    tally = rows()[name].run(Options(share=0.0502, seed=20261128))
    assert tally.failures == []
    assert tally.many >= (LEAST if name != "tir" else LEAST // 2)
    if name != "esi":  # its own row counts no refusals
        assert 0.1 * tally.many < tally.refused < 0.97 * tally.many


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("name", READERS)
def test_damaged_files_of_half_a_night(name):
    assert rows()[name].run(Options(share=0.5, seed=7)).failures == []


def test_undamaged_tables_pass_the_comparison_and_a_lost_row_does_not():
    for kind in text.KINDS.values():
        for encoding in text.ENCODINGS:
            data = kind.encode(encoding)
            table = text.read_table(data)
            assert len(table.lines) == len(text.SHORT) and text.left_out(table) == 0
            text.compare_with_pandas(table, data)
    with pytest.raises(AssertionError, match="12 of 13 lines"):
        text.compare_with_pandas(table, data + text.KINDS["blanks"].splitlines()[3].encode())


def test_a_wrong_value_fails_the_comparison():
    data = text.KINDS["comma"].encode()
    table = text.read_table(data)
    with pytest.raises(AssertionError):
        text.compare_with_pandas(table, data.replace(b"-1234.5", b"-1234.6"))
    with pytest.raises(AssertionError, match="48 of 47 values"):
        file = parse_tydex(text.TYDEX, "a.tdx")
        text.compare_tydex(file, text.TYDEX.replace("3700.125", ""))


@pytest.mark.parametrize(
    ("place", "name", "row"),
    [(bag_files, "import_bag", name) for name in ("mcap", "sqlite", "ros1")]
    + [(table_files, "read_parquet", "parquet")],
)
def test_a_reader_that_loses_its_last_row_fails(place, name, row, monkeypatch):
    """Or its whole column, where all files have one length."""
    read = getattr(place, name)

    def short(*arguments):
        found = read(*arguments)
        columns = {k: v[:-1] for k, v in found.columns.items()}
        return Loaded(columns, found.facts, found.remarks)

    monkeypatch.setattr(place, name, short)
    assert rows()[row].run(Options(share=0.003)).failures


def test_a_traceback_and_a_refusal_without_a_place_are_failures(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"1,2")

    def raising(error):
        def read(_):
            raise error

        return judged(Options(share=1.0), 3, path, read, lambda *_: None)

    assert raising(FlatplankError("what", "a.csv", "do")).failures == []
    assert raising(FlatplankError("what", "a.csv", "do")).refused == 3
    for error in (ValueError("x"), FlatplankError("what", "", "do"), MemoryError()):
        assert len(raising(error).failures) == 3


def test_random_bytes_are_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"x")

    def read(path: Path) -> TextTable:
        return text.read_table(path.read_bytes())

    def draw(_: bytes, random: np.random.Generator) -> bytes:
        return random.bytes(int(random.integers(1, 400)))

    def compare(table: TextTable, path: Path) -> None:
        text.compare_with_pandas(table, path.read_bytes())

    tally = judged(Options(seed=4), 500, path, read, compare, by_numpy(draw))
    assert tally.failures == [] and tally.refused > 400


def test_damaged_campaigns_lose_no_row_without_a_word(tmp_path):
    random = np.random.default_rng(5)
    whole = text.written(";", "comma").encode()
    used = 0
    for _ in range(250):
        campaign = a_campaign(tmp_path, damaged(whole, random))
        tables = list(campaign.tables())
        told = "\n".join(map(str, campaign.problems))
        assert len(campaign.problems) == len(told.splitlines())
        if not tables:
            assert campaign.problems
            continue
        used += 1
        (table,) = tables
        lines = lines_of((tmp_path / "r.csv").read_text("cp1252"))
        names = next(k for k, line in enumerate(lines) if "plank_position" in line)
        filled = sum(bool(re.match(r"[\d-]", line)) for line in lines[names + 1 :])
        assert len(table) >= filled or "left out" in told, told
    assert used > 25
