# SPDX-License-Identifier: Apache-2.0
"""A proposal by mouse: what no library explains gets a name, goes into the model, is confirmed."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from looks import looked_after, take
from made_up import campaign
from panel_rig import shows, status, wait_for

from flatplank_analysis.effects.checks import check_effect
from flatplank_analysis.effects.grammar.former import sentence_of
from flatplank_analysis.effects.registry import load_file
from flatplank_panel.analysis import proposing
from flatplank_panel.analysis.worker import do_request
from flatplank_sim.sealed.conditions import STEP
from flatplank_sim.sealed.generate import make_challenge, more_runs

pytestmark = pytest.mark.timeout(900)  # whole searches: a busy machine takes minutes


def quiet(_text: str, _share: float) -> None:
    """Nobody looks on."""


FORMER = Path(__file__).parents[1] / "discovery" / "former"


def test_nothing_is_added_that_was_not_proposed(tmp_path):
    folder = campaign(tmp_path / "pulled")
    about = {"folder": str(folder), "model": str(folder / "model.yaml")}
    answer = do_request({"do": "accept", "with": {**about, "name": "mine"}}, quiet)
    assert "propose it first" in answer["error"]
    answer = do_request(
        {"do": "confirm", "with": {**about, "name": "mine", "new": str(folder)}}, quiet
    )
    assert "add it first" in answer["error"]
    sentence = sentence_of((FORMER / "fx_bump.txt").read_bytes())
    assert sentence is not None
    proposing._SENTENCES[str(folder)] = sentence
    answer = do_request({"do": "accept", "with": {**about, "name": "../mine"}}, quiet)
    assert "no identifier" in answer["error"]
    answer = do_request({"do": "rename", "with": {**about, "old": "it", "new": "a b"}}, quiet)
    assert "no identifier" in answer["error"]
    assert sorted(folder.glob("*mine*")) == []


@pytest.mark.long
@pytest.mark.browser
def test_a_pull_is_proposed_named_added_and_confirmed_by_mouse(visitor, data: Path, pictures):
    first = make_challenge(data / "pulled", 911, outside="bump")
    more_runs(data / "new_runs", first, [(-0.1, 1), (-0.05, 1), (-0.02, 1)], STEP)
    who = visitor()
    who.tab("Discover")
    shows(who, "pulled (")
    who.click("Open")
    wait_for(lambda: "beyond the floor" in status(who), 300.0, "the base is fitted")
    who.click("Propose")
    said(who, "Proposed: a force in Fx over plank position, only while braking,")
    assert "acts_on: fx" in shown(who)
    wait_for(lambda: not status(who).endswith("…"), what="the progress has gone")
    looked_after(who)
    who.page.set_viewport_size({"width": 1440, "height": 2200})
    take(who, pictures / "panel-proposal.png")
    who.click("Add proposal")
    said(who, "not confirmed yet")
    (name,) = held(first)
    assert who.field("Name of the effect").input_value() == name
    who.fill("Name of the effect", "cable_drag")
    who.click("Rename")
    said(who, f"{name} is cable_drag from now on")
    assert "name: cable_drag" in shown(who)
    assert held(first) == ["cable_drag"]
    assert not (first / f"{name}.yaml").exists()
    (effect,) = load_file(first / "cable_drag.yaml")
    assert check_effect(effect) == []
    who.field("Campaign of new runs").click()
    who.page.get_by_role("option").filter(has_text="new_runs").first.click()
    who.click("Confirm")
    said(who, "in the new runs")
    assert words(who).startswith("confirmed: ")
    take(who, pictures / "panel-confirmed.png")
    who.click("Undo")
    wait_for(lambda: held(first) == [], 120.0, "the effect is out of the file")


def words(who) -> str:
    """What the card of proposals says."""
    return who.page.get_by_role("status").last.text_content() or ""


def said(who, text: str) -> None:
    """The card says so; at once when a button was refused."""

    def says() -> bool:
        refused = who.page.locator(".q-notification").all_text_contents()
        assert not refused, refused
        return text in words(who)

    wait_for(says, 600.0, f"the card says: {text}")


def shown(who) -> str:
    """The file of the effect on the page."""
    return who.page.get_by_role("region", name="Effect file").text_content() or ""


def held(folder: Path) -> list[str]:
    """Effects of the model file."""
    return [e["name"] for e in yaml.safe_load((folder / "model.yaml").read_text())["effects"]]
