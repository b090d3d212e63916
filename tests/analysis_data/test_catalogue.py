# SPDX-License-Identifier: Apache-2.0
"""The catalogue of all runs below a folder: what it has, what it reads again, how it is asked."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from steptable import step_table

import flatplank_analysis as fp
from flatplank_analysis.catalogues.build import updated
from flatplank_analysis.catalogues.conditions import conditions_in
from flatplank_analysis.catalogues.kept import Update, file_of, stored
from flatplank_analysis.cli.catalogue import main as verb
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import record_from_dict


def campaign(folder: Path, tire: str = "TOY", day: str = "2026-05-01", **info) -> Path:
    tables = []
    for kappa in (0.01, -0.01):
        for repeat in (1, 2):
            name = f"{tire}_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_1_r{repeat:02d}.parquet"
            table = step_table(kappa, 1, 5.0, tire=tire, file=name)
            tables.append(table.with_info(repeat=repeat, date=day, file=name, **info))
    return export_campaign(tables, folder)


def bag(folder: Path, **info) -> Path:
    folder.mkdir(parents=True)
    record_from_dict({"tire": "TOY", "status": "complete", **info}).save(folder)
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    return folder


@pytest.fixture
def root(tmp_path: Path) -> Path:
    campaign(tmp_path / "may", day="2026-05-03")
    campaign(tmp_path / "2026" / "june", tire="CON", day="2026-06-10", pressure=2.0)
    bag(tmp_path / "bags" / "one", kappa=0.05, fz=3700.0, pressure=2.5, started="2026-04-01")
    return tmp_path


def test_every_run_below_the_folder_is_a_row(root: Path) -> None:
    rows = fp.catalogue(root).rows
    assert rows.groupby("folder").size().to_dict() == {"2026/june": 4, "bags": 1, "may": 4}
    assert set(rows["quality"]) == {"ok"} and rows["error"].isna().all()
    assert rows.attrs["units"]["fz"] == "N"
    table = stored(root).table
    assert table.schema.field("pressure").metadata == {b"unit": b"bar"}


@pytest.mark.parametrize(
    ("conditions", "count"),
    [
        ({"tire": "toy"}, 5),
        ({"tire": "TOY", "pressure": 2.5, "since": "2026-05-01"}, 4),
        ({"pressure": "29psi"}, 4),
        ({"pressure": "1.9..2.1bar"}, 4),
        ({"load": "3.7kN", "slip": "5"}, 1),
        ({"slip": "-1%"}, 4),
        ({"until": "2026-05-03"}, 5),
        ({"date": "2026-05-03"}, 4),
        ({"quality": "ok", "kind": "slip", "folder": "2026"}, 4),
        ({"bench": "hall 2"}, 0),
        ({"bench": ""}, 9),
        ({"effect": "wear"}, 0),
    ],
)
def test_runs_are_selected(root: Path, conditions: dict, count: int) -> None:
    assert len(fp.catalogue(root).where(**conditions)) == count


@pytest.mark.parametrize(
    ("conditions", "said"),
    [
        ({"tyre": "TOY"}, "no condition 'tyre'; the nearest is 'tire'"),
        ({"pressure": "much"}, "'much' is no number of bar"),
        ({"pressure": "2N"}, "unit 'N' does not fit"),
        ({"since": "May"}, "'May' is no date"),
    ],
)
def test_a_wrong_condition_is_told_in_a_line(root: Path, conditions: dict, said: str) -> None:
    with pytest.raises(FlatplankError, match=said):
        fp.catalogue(root).where(**conditions)


def test_a_line_is_read_as_the_shell_reads_it() -> None:
    said = {"tire": "TOY", "bench": "hall 2", "load": "3000..4000"}
    assert conditions_in("tire=TOY bench='hall 2'  load=3000..4000") == said
    assert conditions_in("") == {}


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("tire", "'tire' is not KEY=VALUE"),
        ("tire=", "'tire=' is not KEY=VALUE"),
        ("bench='hall", "a quote has no end"),
        ("tire=TOY tire=CON", "'tire' is there twice"),
    ],
)
def test_a_line_that_cannot_be_read_is_told(line: str, said: str) -> None:
    with pytest.raises(FlatplankError, match=said):
        conditions_in(line)


def test_only_what_changed_is_read_again(root: Path) -> None:
    assert sorted(updated(root).read) == ["2026/june", "bags", "may"]
    again = updated(root)
    assert not again.read and not again.gone and again.table.num_rows == 9
    bag(root / "bags" / "two", kappa=0.02)
    shutil.rmtree(root / "may")
    third = updated(root)
    assert (third.read, third.gone) == (["bags"], ["may"])
    assert third.table.num_rows == 6
    whole = Update(third.table, third.stamps)
    assert stored(root) == whole
    file_of(root).unlink()
    assert updated(root).table == third.table


def test_a_file_that_cannot_be_read_is_a_row_with_its_error(root: Path, capsys) -> None:
    next((root / "may").glob("*.parquet")).unlink()
    (root / "damaged").mkdir()
    (root / "damaged" / "a.parquet").write_bytes(b"PAR1 nothing")
    (root / "wrong").mkdir()
    (root / "wrong" / "campaign.yaml").write_text("runs: {")
    found = fp.catalogue(root)
    assert len(found.where(folder="may")) == 4
    errors = found.unusable.rows.set_index("folder")["error"]
    assert "no such file" in errors["may"]
    assert "not a whole Parquet file" in errors["damaged"] and "YAML" in errors["wrong"]
    assert verb([str(root)]) == 0
    assert "may: " in capsys.readouterr().out


def test_the_verdict_of_a_diagnosis_stands_at_its_runs(root: Path) -> None:
    fp.catalogue(root)
    said = {"verdict": "found", "effects": [{"name": "road_play"}, {"name": "wear"}]}
    (root / "may" / "diagnosis.json").write_text(json.dumps(said))
    found = fp.catalogue(root).where(verdict="found", effect="wear")
    assert len(found) == 4 and set(found.rows["effects"]) == {"road_play, wear"}
    (root / "may" / "diagnosis.json").write_text("{")
    assert fp.catalogue(root).where(folder="may").rows["error"].str.contains("no diagnosis").all()


def test_the_same_from_processes(root: Path) -> None:
    here = updated(root).table
    file_of(root).unlink()
    assert updated(root, jobs=2).table == here


def test_the_verb_answers_from_the_kept_catalogue(root: Path, capsys) -> None:
    words = ["--where", "tire=CON", "pressure=2bar", "--json"]
    assert verb([str(root), *words]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["rows"]) == 4 and told["rows"][0]["verdict"] is None
    shutil.rmtree(root / "2026")
    assert verb([str(root), *words[:-1]]) == 0
    out = capsys.readouterr().out
    assert "4 runs" in out and "looks for what changed" in out
    assert verb([str(root)]) == 0
    assert "5 runs in 2 folders, 0 read, 1 gone" in capsys.readouterr().out


SLOW_TO_IMPORT = ("pandas", "numba", "matplotlib", "scipy", "flatplank_data.campaign")
ASK = """
import sys
from flatplank_analysis.cli.main import main
words = ["--where", "tire=toy", "pressure=2.5bar", "since=2026-05-01"]
code = main(["catalogue", sys.argv[1], *words])
print(code, [name for name in sys.argv[2:] if name in sys.modules])
"""


def test_a_selection_imports_nothing_that_takes_long(root: Path) -> None:
    fp.catalogue(root)
    command = [sys.executable, "-c", ASK, str(root), *SLOW_TO_IMPORT]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "4 runs" in told and told.endswith("0 []\n")


def test_a_folder_that_cannot_be_written_is_asked_all_the_same(root: Path, monkeypatch) -> None:
    def refuse(*_words, **_more):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    found = updated(root)
    assert not found.kept and found.table.num_rows == 9
    assert not list(file_of(root).parent.iterdir())


def test_the_reference_tire_is_charted_over_days_and_benches(tmp_path: Path, capsys) -> None:
    random = np.random.default_rng(5)
    for k in range(10):
        bench, gain = ("hall 1", 1.0) if k % 2 else ("hall 2", 1.1)
        tables = []
        for kappa in (0.01, -0.01):
            name = f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_1.parquet"
            table = step_table(kappa, 1, 5.0, file=name)
            force = gain * table["fx"] * (1.0 + 0.002 * random.normal())
            dated = table.with_columns(fx=force).with_info(
                date=f"2026-05-{k + 1:02d}", file=name, extra={"bench": bench}
            )
            tables.append(dated)
        export_campaign(tables, tmp_path / "all" / f"s{k}")
    assert verb([str(tmp_path / "all"), "--chart", str(tmp_path / "out"), "--jobs", "1"]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "hall 1: 2026-05-02 s1 to 2026-05-10 s9" in page
    rows = pd.read_csv(tmp_path / "out" / "tables" / "reference.csv")
    means = rows[rows["quantity"].str.startswith("slip")].set_index("bench")["mean"]
    assert means["hall 2"] / means["hall 1"] == pytest.approx(1.1, rel=0.01)
    assert (tmp_path / "out" / "figures" / "reference_C_Fk.svg").exists()
    assert len(updated(tmp_path).stamps) == 10, "the numbers of a report are no campaign"


def test_a_chart_is_of_one_tire(root: Path, capsys) -> None:
    with pytest.raises(FlatplankError, match="are of CON, TOY"):
        verb([str(root), "--chart", str(root / "out"), "--jobs", "1"])
