# SPDX-License-Identifier: Apache-2.0
"""The whole loop of discovery by mouse; judged in the model file, the plan and the report."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
import yaml
from panel_rig import analysts, wait_for

from flatplank_control.sealed.generate import make_challenge

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]

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
    box = who.page.get_by_label("Campaign", exact=True).first
    wait_for(lambda: box.input_value() or True, what="campaigns are listed")
    box.click()
    who.page.get_by_role("option").filter(has_text="challenge").first.click()
    return who


def effects(challenge: Path) -> list[str]:
    """What the model file holds."""
    file = challenge / "model.yaml"
    if not file.exists():
        return []
    return [entry["name"] for entry in yaml.safe_load(file.read_text()).get("effects") or []]


def status(who) -> str:
    return who.page.get_by_role("status").first.text_content() or ""


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
    wait_for(lambda: "screening" in status(analyst), 120.0, "it searches again")
    analyst.click("Cancel")


def test_the_hidden_effect_is_found_by_mouse(analyst, challenge, data):
    begun = time.monotonic()
    analyst.click("Open")
    analyst.page.wait_for_function(CURVES)
    print(f"first picture after {time.monotonic() - begun:.1f} s")
    wait_for(lambda: "beyond the floor" in status(analyst), 120.0, "the base is fitted")
    analyst.click("Diagnose")
    analyst.page.get_by_text("Verdict: found").wait_for(timeout=240_000)
    assert effects(challenge) == []
    analyst.page.get_by_role("button", name="Add road_play", exact=True).click()
    wait_for(lambda: effects(challenge) == ["road_play"], 120.0, "the model file has the effect")
    said = analyst.page.get_by_text("road_play added: error")
    said.wait_for(timeout=120_000)
    numbers = [float(w.strip(",")) for w in said.text_content().split() if w[0].isdigit()]
    before, after, floor = numbers
    assert after < 0.8 * before and after < 1.1 * floor
    analyst.click("Undo")
    wait_for(lambda: effects(challenge) == [], 120.0, "the effect is out of the file")
    analyst.click("Export report")
    page = data / "reports" / "challenge" / "index.html"
    wait_for(page.exists, 120.0, "the report is written")
    assert "road_play" in page.read_text()
