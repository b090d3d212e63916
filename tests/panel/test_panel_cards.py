# SPDX-License-Identifier: Apache-2.0
"""A card is there when it has something to show, and a chart has words for those who do not see
it."""

from __future__ import annotations

import shutil

import pytest
from panel_rig import shows, status, wait_for

from flatplank_analysis.words import explain
from flatplank_panel.views import charts
from flatplank_panel.views.described import described

CONDITIONS = [
    {"condition": "κ -5 %", "rmse": 51.23, "floor": 20.04, "floors": 2.6},
    {"condition": "κ +5 %", "rmse": 14.0, "floor": 20.0, "floors": 0.7},
]
CURVE = {"over": "road displacement [m]", "x": [0.0, 1.0], "measured": [1.0, 90.0],
         "model": [0.0, 100.0]}  # fmt: skip
MAP = {"coordinate": "angle", "unit": "deg", "edges": [0.0, 90.0, 180.0],
       "mean": [[1.5, None], [-3.0, 2.0]]}  # fmt: skip


def test_charts_are_told_in_words():
    bars = described(charts.against_floor(CONDITIONS))
    assert bars == (
        "RMS error of Fx [N]; error: κ -5 % 51.2, κ +5 % 14; floor of the condition: 20 to 20"
    )
    assert described(charts.measured_and_model(CURVE)) == (
        "Fx [N] over road displacement [m]; measured: 1 to 90; model: 0 to 100; residual: -10 to 1"
    )
    assert described(charts.residual_map(MAP, ["a", "b"])) == (
        "angle [deg]; measured minus model [N]: -3 to 2"
    )
    assert described({}) == described(charts.against_floor([])) == ""


def cards(who) -> list[str]:
    """Headings of the cards that are in view."""
    found = who.page.get_by_role("heading").filter(visible=True)
    return found.all_text_contents()


@pytest.mark.browser
def test_a_card_appears_when_it_has_something_to_show(visitor, made_up):
    who = visitor()
    who.tab("Investigate")
    who.button("Begin or go on").wait_for()
    wait_for(lambda: cards(who) == ["Investigate"], what="nothing is known")
    who.tab("Discover")
    who.button("Diagnose").wait_for()
    assert cards(who) == ["Discover"]
    shows(who, "made_up")
    who.click("Open")
    wait_for(lambda: "beyond the floor" in status(who), 120.0, "the base is fitted")
    fitted = ["Discover", "Error against the floor", "Waterfall: error after every step",
              "Measured and model", "Where the error is", "Beyond the library"]  # fmt: skip
    wait_for(lambda: cards(who) == fitted, what="the cards of a fit")
    assert who.page.get_by_role("button", name="Confirm").is_hidden()
    who.page.get_by_role("heading", name="Error against the floor").hover()
    who.page.get_by_role("tooltip").get_by_text(explain("floor").sentence).wait_for()
    drawn = who.page.get_by_role("img").filter(visible=True)
    names = [chart.get_attribute("aria-label") for chart in drawn.all()]
    assert len(names) == 4 and all("[" in name and ";" in name for name in names)
    assert not who.errors


ZOOM = """() => [...document.querySelectorAll(".nicegui-echart")].map(e =>
  getElement(Number(e.id.slice(1))).chart).find(c => c.getOption()?.series?.length === 3
  && c.getOption().dataZoom?.length)"""
"""the chart of measured and model"""


@pytest.mark.browser
def test_what_is_zoomed_and_chosen_outlives_a_refresh(visitor, made_up):
    who = visitor()
    who.tab("Discover")
    shows(who, "made_up")
    who.click("Open")
    wait_for(lambda: "beyond the floor" in status(who), 120.0, "the base is fitted")
    who.choose("Over", "time")
    who.page.wait_for_function(ZOOM)
    who.page.evaluate(f"({ZOOM})().dispatchAction({{type: 'dataZoom', start: 25, end: 75}})")
    who.page.wait_for_function("location.search.includes('over=time')")
    who.page.reload()
    who.page.wait_for_function(f"({ZOOM})()?.getOption().dataZoom[0].start === 25")
    assert who.field("Over").input_value() == "time"
    other = visitor()
    other.page.goto(who.page.url)
    other.page.wait_for_function(f"({ZOOM})()?.getOption().dataZoom[0].start === 0")
    assert not who.errors and not other.errors


@pytest.mark.browser
def test_a_campaign_that_cannot_be_read_says_so_where_its_runs_would_be(visitor, data):
    bad = data / "bad"
    bad.mkdir()
    (bad / "campaign.yaml").write_text("tire: T\n")
    try:
        who = visitor()
        who.tab("Runs")
        who.page.get_by_text("Choose a campaign.").or_(
            who.page.locator(".q-table__bottom").get_by_text("no list")
        ).wait_for()
        who.choose("Campaign", "bad (0 runs)")
        who.page.locator(".q-table__bottom").get_by_text("no list 'runs'").wait_for()
        assert "Curves" not in cards(who)
    finally:
        shutil.rmtree(bad)
