# SPDX-License-Identifier: Apache-2.0
"""Single bad samples decide nothing: floor, error and verdict are those of the clean runs."""

import numpy as np
import pytest
from bristles import Truth, campaign, save

from flatplank_analysis.contact_patch.session import Session

SLIPS = (-0.05, 0.0, 0.05)


@pytest.fixture(scope="module")
def clean():
    """Tables of a campaign with road play, and its error and floor [N]."""
    tables = campaign(Truth(seed=91, slips=SLIPS, play=0.0009))
    session = Session.of_tables(tables)
    return tables, session.numbers(session.fit(None))


def _one_in_all(random, table):
    """The same sample in every run."""
    return {"fx": [(1900, 2e4)]}


def _three_per_run(random, table):
    rows = random.choice(len(table), 3, replace=False)
    return {"fx": [(row, random.choice([-2e4, 2e4])) for row in rows]}


def _loads_and_neighbours(random, table):
    first = int(random.integers(200, len(table) - 200))
    return {"fz": [(first, 9e3), (first + 1, -9e3)], "fx": [(first + 40, 4e3)]}


def _spoilt(bad, tables, folder) -> Session:
    """The campaign with bad samples, as it is opened from its files."""
    random = np.random.default_rng(5)
    spoilt = []
    for table in tables:
        columns = {name: values.copy() for name, values in table.columns.items()}
        for name, samples in bad(random, table).items():
            for row, size in samples:
                columns[name][row] += size
        spoilt.append(table.with_columns(**columns))
    return Session.open(str(save(spoilt, folder)))


@pytest.mark.parametrize("bad", [_one_in_all, _three_per_run, _loads_and_neighbours])
def test_bad_samples_are_left_out_and_decide_nothing(bad, clean, tmp_path):
    tables, expected = clean
    session = _spoilt(bad, tables, tmp_path)
    found = session.numbers(session.fit(None))
    for key in ("rmse", "floor", "unexplained"):
        assert found[key] == pytest.approx(expected[key], abs=0.03 * expected["rmse"]), key
    told = [p for p in session.campaign.problems if "spikes" in p.what]
    assert {p.file for p in told} == {t.info.file for t in tables}
    assert all("row" in p.what and not p.fatal for p in told)


@pytest.mark.long
@pytest.mark.parametrize("bad", [_one_in_all, _three_per_run])
def test_the_first_effect_beside_bad_samples_is_that_of_the_clean_runs(bad, clean, tmp_path):
    """One sample of 20 kN in all runs hid the play, three per run named an effect that explains
    nothing."""
    tables, _ = clean
    expected, found = (
        session.diagnose().to_dict()
        for session in (Session.of_tables(tables), _spoilt(bad, tables, tmp_path))
    )
    assert found["verdict"] == expected["verdict"]
    effect, same = found["effects"][0], expected["effects"][0]
    assert effect["name"] in (same["name"], *same["class"])
    assert same["interval"][0] <= effect["size"] <= same["interval"][1]
    assert found["rmse_after"] == pytest.approx(expected["rmse_after"], rel=0.03)
