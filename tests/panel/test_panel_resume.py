# SPDX-License-Identifier: Apache-2.0
"""A campaign that was stopped goes on from the page: what is missing is made, and only that."""

from __future__ import annotations

import pytest
import yaml
from panel_rig import wait_for
from short_plan import short_plan

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup

pytestmark = [pytest.mark.browser, pytest.mark.graph, pytest.mark.timeout(240)]


@pytest.fixture
def quick_bench(visitor, observer, tmp_path):
    """Somebody in charge of a bench that makes its cycles as fast as they are asked for."""
    who = visitor()
    wait_for(lambda: "nobody" in who.page.locator("header").text_content(), 20.0, "charge is free")
    who.take()
    if observer.running:
        who.click("Stop bench")
        wait_for(lambda: not observer.running, 60.0, "the bench has stopped")
    setup = BenchSetup(data=str(tmp_path), pace="hold")
    with BenchProcesses(setup, log=tmp_path / "nodes.log") as nodes:
        observer.client.wait_connected(nodes.running, 90.0)
        yield who
        who.click("Hand back")
        who.button("Take charge").wait_for()


def test_the_page_goes_on_with_a_stopped_campaign(quick_bench, data):
    who = quick_bench
    plan = data / "plans" / "one_run.yaml"
    plan.parent.mkdir(exist_ok=True)
    plan.write_text(short_plan("one_run"))
    folder = data / "two_days"

    def says(text: str) -> None:
        who.page.get_by_text(text, exact=True).wait_for(timeout=90_000)

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
