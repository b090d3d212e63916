# SPDX-License-Identifier: Apache-2.0
"""Identity of a run by its samples, and copies, which are no repeats."""

import shutil

import numpy as np
import pytest

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.investigation.loop import rows_of
from flatplank_data.campaign import Campaign
from flatplank_data.identity import identity_of


def test_identity_is_independent_of_file_folder_and_format(write_campaign, make_step):
    made = [make_step(0.02, 1, noise=5.0), make_step(0.02, 2, noise=5.0)]
    known = [identity_of(table) for table in made]
    assert known[0] != known[1]
    for suffix in (".parquet", ".csv"):
        folder = write_campaign(made, suffix, f"as{suffix[1:]}")
        assert [run.identity() for run in Campaign.load(folder).runs] == known


def test_identity_survives_single_precision_and_another_origin_of_time(make_step):
    table = make_step(0.02, 1, noise=5.0)
    narrow = {name: np.float32(values).astype(float) for name, values in table.columns.items()}
    later = table.with_columns(**narrow).with_columns(time=table["time"] + 1.7e9)
    assert identity_of(later.with_info(file="else.csv", start=3)) == identity_of(table)


def test_one_changed_sample_is_another_run(make_step):
    table = make_step(0.02, 1, noise=5.0)
    changed = table["fx"].copy()
    changed[100] += 0.01
    assert identity_of(table.with_columns(fx=changed)) != identity_of(table)


def test_a_copied_file_is_told_and_not_used(write_campaign, make_step):
    folder = write_campaign([make_step(0.02, 1, noise=5.0), make_step(0.02, 2, noise=5.0)])
    (folder / "campaign.yaml").unlink()
    first = min(folder.glob("*.parquet"))
    shutil.copy(first, folder / first.name.replace("_1.parquet", "_3.parquet"))
    campaign = Campaign.load(folder)
    assert len(list(campaign.tables(["fz"]))) == 2
    (problem,) = (p for p in campaign.problems if "same samples" in p.what)
    assert first.name in problem.what and problem.fatal
    assert "\n" not in str(problem) and len(list(campaign.tables())) == 2


def again(table, start):
    """The table under the name of another start."""
    return table.with_info(start=start, file=table.info.file.replace("_1", f"_{start}"))


def test_simulations_without_noise_are_told_apart_by_what_they_measure(write_campaign, make_step):
    """At another load, angle or pressure the forces along the road may be equal bit by bit."""
    table = make_step(0.02, 1)
    others = [
        again(table.with_columns(**{name: table[name] + more}), 2 + k)
        for k, (name, more) in enumerate([("fz", 300.0), ("loaded_radius", 0.001)])
    ]
    assert len(list(Campaign.load(write_campaign([table, *others])).tables(["fx"]))) == 3


def test_a_copy_with_fewer_columns_is_a_copy(write_campaign, make_step):
    table = make_step(0.02, 1, noise=5.0)
    part = again(table.select(["time", "plank_position", "fx", "fz"]), 2)
    campaign = Campaign.load(write_campaign([table, part], ".csv"))
    assert len(list(campaign.tables())) == 1
    (problem,) = (p for p in campaign.problems if p.fatal)
    assert "same samples" in problem.what and "simulation without noise" in problem.remedy


def test_what_is_said_of_a_column_does_not_depend_on_the_columns_that_are_asked_for(
    write_campaign, make_step
):
    table = make_step(0.02, 1, noise=5.0)
    whole = Campaign.load(write_campaign([table], ".parquet", "whole"))
    assert list(whole.tables(["fx"])) and not whole.problems
    names = [name for name in table.columns if name != "fz"]
    folder = write_campaign([table.select(names)], ".parquet", "part")
    for columns in (["fx"], ["fx", "fz"], None):
        campaign = Campaign.load(folder)
        assert list(campaign.tables(columns))
        assert [p.what for p in campaign.problems] == ["no column 'fz': no fit"]


@pytest.mark.parametrize("label", [{"start": 2}, {"start": 1, "pressure": 2.8}])
def test_a_copy_is_in_no_held_out_condition_and_no_evidence_of_a_batch(
    write_campaign, make_step, label
):
    """Whatever its record says: as another start, or in a condition that is held out."""
    made = [make_step(k, 1, noise=5.0) for k in (-0.02, 0.0, 0.02)]
    copied = made[2].with_info(file="batch_02.parquet", uuid="", **label)
    own = make_step(0.02, 3, noise=5.0).with_info(file="batch_02_own.parquet")
    session = Session.of(Campaign.load(write_campaign([*made, copied, own])))
    names = session.data.runs.names
    assert len(names) == 4 and "batch_02" not in names
    assert len(session.data.runs.condition_names) == 3
    rows = rows_of(session, ["batch_02.parquet", "batch_02_own.parquet"])
    assert [names[row] for row in rows] == ["batch_02_own"]
