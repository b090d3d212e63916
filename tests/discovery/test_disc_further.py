# SPDX-License-Identifier: Apache-2.0
"""Columns of other names: CSV and Parquet keep them for the search, all else is the same."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from bristles import Truth, campaign, save

from flatplank_analysis.contact_patch.data import from_tables, load_runs
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError


@pytest.fixture(scope="module")
def tables():
    return campaign(Truth(seed=5, slips=(-0.05, 0.05), repeats=2))


def test_a_further_column_is_a_coordinate_with_its_unit(tables):
    warm = [t.with_columns(**{"oil [degC]": 20.0 + t["plank_position"]}) for t in tables]
    data = from_tables(warm)
    assert data.further["oil"].unit == "degC"
    assert np.allclose(data.coordinate("oil"), 20.0 + data.position, atol=0.02)
    assert np.array_equal(data.runs.measured, from_tables(tables).runs.measured)
    with pytest.raises(FlatplankError, match="no 'oil'"):
        from_tables(tables).coordinate("oil")


def test_a_column_that_a_run_lacks_is_none(tables):
    some = [tables[0].with_columns(oil=tables[0]["fx"]), *tables[1:]]
    assert from_tables(some).further == {}


def test_gaps_in_a_further_column_take_no_sample_away(tables):
    gappy = []
    for t in tables:
        oil = 20.0 + t["plank_position"]
        oil[::3] = np.nan
        gappy.append(t.with_columns(oil=oil))
    data = from_tables(gappy)
    assert np.array_equal(data.runs.measured, from_tables(tables).runs.measured)
    assert np.allclose(data.coordinate("oil"), 20.0 + data.position, atol=0.02)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_files_keep_it(kind, tables, tmp_path):
    save(tables, tmp_path)
    for t in tables:
        path = tmp_path / t.info.file
        old = pq.read_table(path)
        more = old.append_column("oil [degC]", pa.array(np.full(len(t), 21.5)))
        more = more.append_column("note", pa.array(["x"] * len(t))) if kind == "parquet" else more
        pq.write_table(more, path)
    if kind == "csv":
        names = {}
        for t in tables:
            frame = pq.read_table(tmp_path / t.info.file).to_pandas()
            (tmp_path / t.info.file).unlink()
            names[t.info.file] = f"{t.info.name}.csv"
            units = t.units
            frame.columns = [c if "[" in c else f"{c} [{units[c]}]" for c in frame.columns]
            frame.to_csv(tmp_path / names[t.info.file], index=False)
        listed = tmp_path / "campaign.yaml"
        text = listed.read_text()
        for old_name, new_name in names.items():
            text = text.replace(old_name, new_name)
        listed.write_text(text)
    campaign_ = Campaign.load(tmp_path)
    data = load_runs(campaign_)
    assert list(data.further) == ["oil"]
    assert np.allclose(data.coordinate("oil"), 21.5)
    assert "oil [degC]" not in next(campaign_.tables()).columns
