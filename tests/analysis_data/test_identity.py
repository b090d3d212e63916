# SPDX-License-Identifier: Apache-2.0
"""Identity of a run by its samples, and copies, which are no repeats."""

import shutil

import numpy as np

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
    assert first.name in problem.what and "same samples" in problem.what and problem.fatal
    assert "\n" not in str(problem) and len(list(campaign.tables())) == 2
