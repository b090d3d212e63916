# SPDX-License-Identifier: Apache-2.0
"""MDF4: what asammdf finds in our exports, and what we find in files of others."""

from __future__ import annotations

import json
import sys
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from bagmaker import write_run
from steptable import step_table

from flatplank_analysis.cli.table import main as table
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign
from flatplank_data.mdf import TEXTS, write_mdf4
from flatplank_data.readers import read_description
from flatplank_data.readers.base import Request
from flatplank_data.readers.mdf4 import read_mdf4
from flatplank_data.store import LocalStore
from flatplank_data.table import COLUMN_UNITS, MeasurementTable

STAMPS = 0.1 * np.arange(50)


def write(path: Path, *groups: list[Signal], version: str = "4.10") -> None:
    with MDF(version=version) as file:
        for group in groups:
            file.append(group, common_timebase=True)
        file.save(path, overwrite=True)


def channel(name: str, unit: str, values: np.ndarray = STAMPS, times=STAMPS) -> Signal:
    encoding = "utf-8" if values.dtype.kind == "S" else None
    return Signal(values, times, name=name, unit=unit, encoding=encoding)


def read(path: Path, **options) -> MeasurementTable:
    found = read_mdf4(Request(LocalStore(str(path.parent)), path.name, **options))
    return MeasurementTable(found.columns)


@pytest.fixture
def run() -> MeasurementTable:
    return step_table(
        0.05, noise=10.0, operator="Ada Lovelace", date="2026-05-01T08:30:00", notes="new rim"
    )


def test_asammdf_finds_values_units_comments_times_and_record(run, tmp_path: Path) -> None:
    write_mdf4(run, tmp_path / "run.mf4")
    with MDF(tmp_path / "run.mf4") as file:
        assert file.version == "4.10" and len(file.groups) == 1
        for name in set(run.columns) - {"time"}:
            signal = file.get(name)
            np.testing.assert_array_equal(signal.samples, run[name])
            np.testing.assert_array_equal(signal.timestamps, run["time"])
            assert (signal.unit, signal.comment) == (COLUMN_UNITS[name], TEXTS[name])
        master = file.groups[0].channels[file.masters_db[0]]
        assert (master.name, master.unit) == ("time", "s")
        assert file.header.author == "Ada Lovelace" and file.header.subject == run.info.tire
        assert file.header.start_time == datetime(2026, 5, 1, 8, 30, tzinfo=timezone.utc)
        assert "new rim" in file.header.description and "slip, κ +5 %" in file.header.description
        record, name = file.extract_attachment(index=0)[:2]
        assert str(name) == "run.json"
        assert json.loads(record)["kappa"] == 0.05


def test_every_column_has_a_comment() -> None:
    assert TEXTS.keys() == COLUMN_UNITS.keys() - {"time"}


def test_the_command_exports_a_campaign_and_the_export_is_a_campaign(run, tmp_path: Path) -> None:
    folder = export_campaign([run], tmp_path / "c")
    words = [str(folder), "--export", str(tmp_path / "mdf"), "--as", ".mf4", "--json"]
    assert table(words) == 0
    (found,) = Campaign.load(tmp_path / "mdf").tables()
    for name, values in run.columns.items():
        np.testing.assert_array_equal(found[name], values)
    assert found.info.operator == "Ada Lovelace" and found.info.condition == run.info.condition
    # without campaign.yaml the attached record says what the run is
    (tmp_path / "mdf" / "campaign.yaml").unlink()
    (alone,) = Campaign.load(tmp_path / "mdf").tables()
    assert alone.info.condition == run.info.condition and alone.info.notes == "new rim"
    (file,) = (tmp_path / "mdf").glob("*.mf4")
    assert read_description(LocalStore(str(file.parent)), file.name)["tire"] == run.info.tire


def test_a_bag_is_exported(tmp_path: Path) -> None:
    record = "kappa: 0.05\nfz: 3700.0\nstep_position: 1.5\neffective_rolling_radius: 0.31\n"
    write_run(tmp_path / "bags" / "one", dict(step_table(0.05).columns), record, "one")
    words = [str(tmp_path / "bags"), "--export", str(tmp_path / "mdf"), "--as", ".mf4", "--json"]
    assert table(words) == 0
    (measured,) = Campaign.load(tmp_path / "bags").tables()
    with MDF(tmp_path / "mdf" / "one.mf4") as file:
        for name in set(measured.columns) - {"time"}:
            np.testing.assert_array_equal(file.get(name).samples, measured[name])
            np.testing.assert_array_equal(file.get(name).timestamps, measured["time"])


def test_a_file_of_another_recorder_is_read_in_si(tmp_path: Path) -> None:
    fast = np.linspace(0.0, 4.9, 500)
    write(
        tmp_path / "x.mf4",
        [channel("Fx", "kN"), channel("plank position", "mm"), channel("wheel_angle", ""),
         channel("tread", "degC"), channel("state", "", np.array([b"on"] * 50))],
        [channel("Fz", "N", fast, fast)],
    )  # fmt: skip
    found = read(tmp_path / "x.mf4")
    np.testing.assert_allclose(found["fx"], 1e3 * STAMPS)
    np.testing.assert_allclose(found["plank_position"], 1e-3 * STAMPS)
    np.testing.assert_array_equal(found["wheel_angle"], STAMPS)
    np.testing.assert_array_equal(found["time"], STAMPS)
    assert set(found.columns) == {"time", "fx", "plank_position", "wheel_angle"}
    said = " ".join(read_mdf4(Request(LocalStore(str(tmp_path)), "x.mf4")).remarks)
    assert "fz: in another channel group, with its own times, and left out" in said
    assert set(read(tmp_path / "x.mf4", columns=["fx"]).columns) == {"fx"}
    more = read(tmp_path / "x.mf4", further=True)
    assert "tread [degC]" in more and "state" not in more


@pytest.mark.parametrize(
    ("group", "version", "said"),
    [
        ([channel("a", "N")], "4.10", "no channel group has a known column"),
        ([channel("fx", "bar")], "4.10", "bar"),
        ([channel("fx", "N", np.array([b"no"] * 50))], "4.10", "not numbers; export it as"),
        ([channel("fx", "N")], "3.30", "MDF 3.30, which is older than 4; convert it"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_in_one_line(
    group: list[Signal], version: str, said: str, tmp_path: Path
) -> None:
    write(tmp_path / "x.mf4" if version > "4" else tmp_path / "x.mdf", group, version=version)
    for old in tmp_path.glob("x.mdf"):
        old.rename(tmp_path / "x.mf4")
    with pytest.raises(FlatplankError, match=said) as caught:
        read(tmp_path / "x.mf4")
    assert "\n" not in str(caught.value) and "x.mf4" in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7])
def test_a_damaged_file_is_one_line(share: float, run, tmp_path: Path) -> None:
    write_mdf4(run, tmp_path / "run.mf4")
    whole = (tmp_path / "run.mf4").read_bytes()
    (tmp_path / "run.mf4").write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(FlatplankError, match=r"run.mf4: not a whole MDF4 file .*copy it again"):
        read(tmp_path / "run.mf4")


def test_without_the_package_one_line_says_what_to_install(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_mdf4(run, tmp_path / "run.mf4")
    monkeypatch.setitem(sys.modules, "asammdf", None)
    for act in (lambda: write_mdf4(run, tmp_path / "y.mf4"), lambda: read(tmp_path / "run.mf4")):
        with pytest.raises(FlatplankError, match=r"mf4: MDF4 needs .*; pip install asammdf"):
            act()


def test_a_table_without_times_has_no_channels(tmp_path: Path) -> None:
    with pytest.raises(FlatplankError, match="no column 'time'"):
        write_mdf4(MeasurementTable({"fx": STAMPS}), tmp_path / "x.mf4")
