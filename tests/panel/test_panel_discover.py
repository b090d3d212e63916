# SPDX-License-Identifier: Apache-2.0
"""The whole loop of discovery by mouse; judged in the model file, the plan and the report."""

from __future__ import annotations

import re
import shutil
import time
from pathlib import Path

import pytest
import yaml
from looks import looked_after, take
from panel_rig import analysts, shows, status, wait_for

from flatplank_sim.sealed.generate import make_challenge

pytestmark = pytest.mark.browser

SEED = 4
CURVES = """() => [...document.querySelectorAll("div[id^=c]")].some(e => {
  const shown = (getElement(Number(e.id.slice(1))) || {}).chart, o = shown && shown.getOption();
  return o && (o.xAxis || []).some(a => a.name === "road displacement [m]")
    && (o.series || []).some(s => s.data && s.data.length > 1);
})"""
"""a chart over the road has lines"""


@pytest.fixture(scope="module")
def challenge(data: Path, address: str) -> Path:
    return make_challenge(data / "challenge", SEED)


@pytest.fixture
def analyst(visitor, challenge):
    """In front of the page Discover, with the campaign chosen."""
    who = visitor()
    who.tab("Discover")
    shows(who, "challenge")
    return who


def effects(challenge: Path) -> list[str]:
    """What the model file holds."""
    file = challenge / "model.yaml"
    if not file.exists():
        return []
    return [entry["name"] for entry in yaml.safe_load(file.read_text()).get("effects") or []]


def test_a_search_is_cancelled_and_begun_again(analyst):
    analyst.click("Open")
    wait_for(lambda: "beyond the floor" in status(analyst), 120.0, "the base is fitted")
    before = analysts()
    analyst.click("Diagnose")
    wait_for(lambda: status(analyst).endswith("…"), 30.0, "progress is shown")
    analyst.click("Cancel")
    wait_for(lambda: before - analysts(), 30.0, "the process of the search has ended")
    analyst.said("cancelled")
    analyst.click("Diagnose")
    wait_for(lambda: "effects beside" in status(analyst), 120.0, "it searches again")
    analyst.click("Cancel")


def send_the_next_run(who, data: Path) -> None:
    """The proposed run becomes a plan, and the page Bench offers it."""
    who.click("Send to the plan")
    plan = data / "plans" / "next_run_made_up.yaml"
    wait_for(plan.exists, 30.0, "the plan is written")
    runs = yaml.safe_load(plan.read_text())["runs"]
    assert {(r["kappa"], r["step_position"]) for r in runs} == {
        (-0.05, 2.2), (0.02, 2.2), (0.05, 2.2)
    }  # fmt: skip
    who.tab("Bench")
    who.tab("Measure")
    who.page.get_by_role("button", name="Look for plans again").click()
    who.choose("Plan", "plans/next_run_made_up.yaml")
    who.tab("Discover")


@pytest.mark.long
def test_two_analysts_do_not_disturb_each_other(analyst, visitor, challenge, made_up, data):
    """B opens another campaign and cancels; A goes on with its own."""
    analyst.click("Look for campaigns again")
    analyst.click("Open")
    wait_for(lambda: "beyond the floor" in status(analyst), 120.0, "the base is fitted")
    b = visitor()
    b.tab("Discover")
    shows(b, "made_up")
    b.click("Open")
    wait_for(lambda: "beyond the floor" in status(b), 120.0, "the other base is fitted")
    analyst.click("Diagnose")
    wait_for(lambda: "effects beside" in status(analyst), 120.0, "A searches")
    searching = analysts()
    b.click("Diagnose")
    wait_for(lambda: "waiting until other work is done" in status(b), 30.0, "B waits")
    b.click("Cancel")
    b.said("cancelled")
    assert analysts() == searching and status(analyst).endswith("…")
    shows(analyst, "made_up")
    wait_for(lambda: searching - analysts(), 30.0, "A has laid its search away")
    wait_for(lambda: status(analyst) == "Open the campaign.", 30.0, "A has nothing open")
    shows(analyst, "challenge")
    analyst.click("Open")
    wait_for(lambda: "beyond the floor" in status(analyst), 120.0, "A is back")
    b.click("Diagnose")
    b.page.get_by_text("measure the conditions that show it").wait_for(timeout=240_000)
    send_the_next_run(b, data)
    add = b.page.get_by_role("button", name=re.compile("^Add ")).first
    name = add.get_attribute("aria-label").removeprefix("Add ")
    add.click()
    wait_for(lambda: effects(made_up) == [name], 120.0, "B has added it to its own")
    assert effects(challenge) == []


def test_the_hidden_effect_is_found_by_mouse(analyst, challenge, data, pictures):
    begun = time.monotonic()
    analyst.click("Open")
    analyst.page.wait_for_function(CURVES)
    print(f"first picture after {time.monotonic() - begun:.1f} s")
    wait_for(lambda: "beyond the floor" in status(analyst), 120.0, "the base is fitted")
    analyst.click("Diagnose")
    analyst.page.get_by_text("Verdict: found").wait_for(timeout=240_000)
    assert effects(challenge) == []
    looked_after(analyst)
    analyst.page.get_by_role("button", name="Add road_play", exact=True).click()
    wait_for(lambda: effects(challenge) == ["road_play"], 120.0, "the model file has the effect")
    said = analyst.page.get_by_text("road_play or rack_backlash added: error")
    said.wait_for(timeout=120_000)
    numbers = [float(w.strip(",")) for w in said.text_content().split() if w[0].isdigit()]
    before, after, floor = numbers
    assert after < 0.8 * before and after < 1.1 * floor
    analyst.page.set_viewport_size({"width": 1440, "height": 1600})
    analyst.page.evaluate("window.scrollTo(0, 0)")
    take(analyst, pictures / "panel-discover.png")
    analyst.click("Undo")
    wait_for(lambda: effects(challenge) == [], 120.0, "the effect is out of the file")
    analyst.click("Export report")
    page = data / "reports" / "challenge" / "index.html"
    wait_for(page.exists, 120.0, "the report is written")
    assert "road_play" in page.read_text()


@pytest.mark.long
def test_a_campaign_with_something_hidden_is_simulated(visitor, data):
    who = visitor()
    who.tab("Discover")
    who.fill("New campaign", "hidden_7")
    who.fill("Seed", 7)
    who.click("Simulate with a hidden effect")
    wait_for(lambda: "of 27 simulated" in status(who), 60.0, "progress is shown")
    wait_for(lambda: "something is hidden" in status(who), 200.0, "the campaign is there")
    assert len(list((data / "hidden_7").glob("*.parquet"))) == 27
    assert (data / "hidden_7" / "answer.sealed").exists()
    who.click("Open")
    wait_for(lambda: "beyond the floor" in status(who), 120.0, "it is open")
    shutil.rmtree(data / "hidden_7")
