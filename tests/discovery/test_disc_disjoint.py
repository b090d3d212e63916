# SPDX-License-Identifier: Apache-2.0
"""Runs that must not be in two sets are found under every name, folder and format."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest
from bristles import Truth, campaign, save

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.proposal.confirm import new_sessions
from flatplank_data.campaign import Campaign
from flatplank_data.disjoint import shared_runs
from flatplank_data.errors import FlatplankError
from flatplank_data.yaml_text import dump_yaml, parse_yaml

SLIPS = (-0.05, -0.01, 0.01, 0.05)


@pytest.fixture(scope="module")
def search(tmp_path_factory) -> Path:
    """The runs of a search."""
    return save(campaign(Truth(seed=41, slips=SLIPS, repeats=2)), tmp_path_factory.mktemp("s"))


@pytest.fixture(scope="module")
def other(tmp_path_factory) -> Path:
    """New runs of the same names."""
    return save(campaign(Truth(seed=42, slips=SLIPS, repeats=2)), tmp_path_factory.mktemp("o"))


def spelled(search: Path, _place: Path) -> str:
    return f"{search}/../{search.name}/"


def linked(search: Path, place: Path) -> str:
    place.symlink_to(search)
    return str(place)


def copied(search: Path, place: Path) -> str:
    shutil.copytree(search, place)
    return str(place)


def of_another_format(search: Path, place: Path) -> str:
    """The same samples as CSV, under other file names."""
    copied(search, place)
    text = (place / "campaign.yaml").read_text()
    for i, file in enumerate(sorted(place.glob("*.parquet"))):
        pd.read_parquet(file).to_csv(place / f"another_{i}.csv", index=False)
        text = text.replace(file.name, f"another_{i}.csv")
        file.unlink()
    (place / "campaign.yaml").write_text(text)
    return str(place)


@pytest.mark.parametrize("way", [spelled, linked, copied, of_another_format])
def test_runs_of_the_search_are_refused_whatever_they_are_called(way, search, tmp_path) -> None:
    folder = way(search, tmp_path / "new")
    count = len(Campaign.load(search).runs)
    assert len(shared_runs(Campaign.load(folder).runs, Campaign.load(search).runs)) == count
    with pytest.raises(FlatplankError, match="are the runs of the search.* and 7 more; measure"):
        new_sessions(Session.open(str(search)), [folder])


def test_one_run_among_new_ones_is_found(search, other) -> None:
    session = Session.open(str(search))
    ((_, new),) = new_sessions(session, [str(other)])
    assert len(new.campaign.runs) == 8
    mixed = [*new.campaign.runs, session.campaign.runs[3]]
    file = session.campaign.runs[3].info.file
    assert shared_runs(mixed, session.campaign.runs) == [(file, file)]


def beside_copied(folder: Path, file: str) -> str:
    shutil.copy(folder / file, folder / "another.parquet")
    return "another.parquet"


def beside_linked(folder: Path, file: str) -> str:
    (folder / "another.parquet").symlink_to(folder / file)
    return "another.parquet"


def beside_spelled(_folder: Path, file: str) -> str:
    return f"./{file}"


def beside_of_another_format(folder: Path, file: str) -> str:
    pd.read_parquet(folder / file).to_csv(folder / "another.csv", index=False)
    return "another.csv"


BESIDE = [beside_copied, beside_linked, beside_spelled, beside_of_another_format]


@pytest.mark.parametrize("way", BESIDE)
def test_a_copy_beside_its_run_is_in_no_set_whether_fitted_or_held_out(way, search, tmp_path):
    """The runs of a batch, those that are fitted and those that are held out, are parts of one
    folder: a copy there would be in two of them."""
    folder = tmp_path / "c"
    shutil.copytree(search, folder)
    listed = parse_yaml((folder / "campaign.yaml").read_text())
    entry = dict(listed["runs"][3])
    entry["file"] = way(folder, entry["file"])
    listed["runs"].append(entry)
    (folder / "campaign.yaml").write_text(dump_yaml(listed))
    session = Session.open(str(folder))
    used = [run.info.file for run in Session.open(str(search)).campaign.runs]
    tables = [table.info.file for table in session.campaign.tables()]
    assert tables == used
    assert any("another" in str(p) or "./" in str(p) for p in session.campaign.problems)
