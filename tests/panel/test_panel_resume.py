# SPDX-License-Identifier: Apache-2.0
"""A campaign that was stopped goes on from the page: what is missing is made, and only that."""

from __future__ import annotations

import pytest
import yaml
from panel_rig import wait_for
from short_plan import short_plan

pytestmark = [pytest.mark.browser, pytest.mark.graph, pytest.mark.long]


def test_the_page_goes_on_with_a_stopped_campaign(operator, data):
    who = operator
    plan = data / "plans" / "one_run.yaml"
    plan.parent.mkdir(exist_ok=True)
    plan.write_text(short_plan("one_run"))
    folder = data / "two_days"

    def says(text: str) -> None:
        who.page.get_by_text(text, exact=True).wait_for(timeout=150_000)

    who.tab("Measure")
    who.fill("Folder below the data folder", folder.name)
    who.click("Look for plans again")
    who.choose("Plan", "plans/one_run.yaml")
    who.click("Start campaign")
    wait_for(lambda: list(folder.glob("*/*.mcap")), 90.0, "a bag is open")
    who.click("Stop measurement")
    says("cancelled")
    assert not (folder / "campaign.yaml").exists()
    who.click("Start campaign")
    says("complete")
    who.click("Start campaign")
    says("all 1 runs were there; another folder begins anew")
    assert len(yaml.safe_load((folder / "campaign.yaml").read_text())["runs"]) == 1
