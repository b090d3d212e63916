# SPDX-License-Identifier: Apache-2.0
"""Two campaigns over each other: the same conditions, and what lies between them."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from made_up import campaign

from flatplank_data.errors import FlatplankError
from flatplank_panel.analysis import browse_jobs, repeats
from flatplank_panel.analysis.worker import to_strict_json
from flatplank_panel.views import charts
from flatplank_panel.views.described import described


def quiet(_text: str, _share: float) -> None:
    pass


def curve(condition: str, low: float, high: float, slope: float) -> dict:
    x = np.linspace(low, high, 50)
    return {"condition": condition, "points": np.stack([x, slope * x], axis=1)}


def test_the_difference_is_that_of_the_means_where_all_are_measured():
    before = [curve("a", 0.0, 4.0, 2.0), curve("a", 0.5, 4.0, 4.0), curve("b", 0.0, 4.0, 1.0)]
    after = [curve("a", 0.0, 3.5, 6.0), curve("c", 0.0, 4.0, 1.0)]
    (only,) = repeats.differences(before, after)
    x, rest = only["points"].T
    assert only["condition"] == "a" and (x[0], x[-1]) == (0.5, 3.5)
    assert rest == pytest.approx(3.0 * x)  # 6 x minus the mean of 2 x and 4 x
    # rms of 3 x between 0.5 and 3.5: 3 sqrt((3.5^3 - 0.5^3) / (3 (3.5 - 0.5)))
    assert only["rms"] == pytest.approx(3.0 * np.sqrt((3.5**3 - 0.5**3) / 9.0), rel=1e-3)


def test_a_campaign_lies_over_another_in_the_conditions_that_are_drawn(tmp_path):
    before, after = (campaign(tmp_path / name) for name in ("before", "after"))
    files = [r["file"] for r in browse_jobs.runs(quiet, str(before))["rows"]][:4]
    found = to_strict_json(
        browse_jobs.curves(quiet, str(before), files, "fx", "plank_position", beside=str(after))
    )
    conditions = [c["condition"] for c in found["curves"]]
    assert sorted(c["condition"] for c in found["others"]) == sorted(conditions)
    assert [d["rms"] for d in found["differences"]] == [0.0, 0.0]  # it is the same campaign
    drawn = charts.two_campaigns(found, ("before", "after"), "x [m]", "Fx [N]")
    styles = {s["name"]: s["lineStyle"]["type"] for s in drawn["series"][:8]}
    assert styles == {
        "κ -5 %, before": "solid", "κ +2 %, before": "solid",
        "κ -5 %, after": "dashed", "κ +2 %, after": "dashed",
    }  # fmt: skip
    assert drawn["yAxis"][1]["name"] == "ΔFx [N]"
    assert "after minus before: 0 to 0" in described(drawn)


def test_a_campaign_of_other_conditions_is_refused_with_its_name(tmp_path):
    before, after = (campaign(tmp_path / name) for name in ("before", "after"))
    text = (after / "campaign.yaml").read_text()
    (after / "campaign.yaml").write_text(text.replace("fz: 3700.0", "fz: 5000.0"))
    files = [r["file"] for r in browse_jobs.runs(quiet, str(before))["rows"]]
    with pytest.raises(
        FlatplankError, match=r"after: no run in a condition of the drawn runs; choose"
    ):
        browse_jobs.curves(quiet, str(before), files, "fx", "plank_position", beside=str(after))


@pytest.mark.browser
def test_the_page_draws_both_and_tells_how_far_they_are_away(visitor, data):
    names = ("before", "after")
    for name, pull in zip(names, (120.0, 0.0), strict=True):
        campaign(data / name, pull=pull)
    try:
        who = visitor()
        who.tab("Runs")
        who.choose("Campaign", "before (9 runs)")
        who.page.get_by_text("Scatter between repeats").wait_for()
        who.choose("Another campaign over it", "after (9 runs)")
        who.page.get_by_text("after minus before, rms, κ -5 %: ").wait_for()
        who.page.get_by_role("img", name="κ +5 %, after minus before").wait_for()
        who.choose("Another campaign over it", "none")
        who.page.get_by_role("img", name="Fx [N] over road displacement [m]; κ -5 %: ").wait_for()
        assert not who.errors
    finally:
        for name in names:
            shutil.rmtree(data / name)
