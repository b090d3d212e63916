# SPDX-License-Identifier: Apache-2.0
"""Loading is told with a count, and only once."""

from __future__ import annotations

import pytest
from made_up import campaign

from flatplank_panel.analysis.worker import do_request

COUNTED = [f"reading run {k} of 9" for k in range(1, 10)]


@pytest.fixture
def folder(tmp_path) -> str:
    return str(campaign(tmp_path / "made_up"))


def said(job: str, **about) -> list[str]:
    """What a job says while it works; it must succeed."""
    told: list[tuple[str, float]] = []
    answer = do_request({"do": job, "with": about}, lambda *one: told.append(one))
    assert "error" not in answer
    assert all(0.0 <= share <= 1.0 for _, share in told)
    return [text for text, _ in told]


def test_the_runs_of_a_campaign_are_counted_as_they_are_read(folder):
    assert said("runs", folder=folder) == COUNTED
    assert said("runs", folder=folder) == []


def test_curves_are_counted_as_they_are_read(folder):
    said("runs", folder=folder)
    some = [f"TOY_REL_LNG_5perc_T_p25_Fz3700_{k}.parquet" for k in (1, 2)]
    told = said("curves", folder=folder, files=some, channel="fx", over="plank_position")
    assert told == ["reading run 1 of 2", "reading run 2 of 2"]


def test_a_campaign_that_is_opened_for_a_fit_is_counted(folder):
    about = {"folder": folder, "model": f"{folder}/model.yaml"}
    assert said("open", **about) == 2 * COUNTED  # its records, then its samples
    assert COUNTED[0] not in said("compare", **about)
