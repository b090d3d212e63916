# SPDX-License-Identifier: Apache-2.0
"""A bench without settings made by the simulated operator, started elsewhere: people are asked."""

from __future__ import annotations

import subprocess
import sys
from contextlib import contextmanager

import pytest
from panel_rig import wait_for

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup

pytestmark = [pytest.mark.browser, pytest.mark.graph]


@contextmanager
def bench_by_hand(folder):
    """The simulated bench; its axle is lowered under a name that nobody knows."""
    setup = BenchSetup(data=str(folder / "data"), rate_hz=100)
    log = folder / "nodes.log"
    nodes = BenchProcesses(setup, log=log, without=frozenset({"simulated_plant"}))
    parameters = setup.write(folder / "parameters")["simulated_plant"]
    options = ["-r", "__node:=simulated_plant", "-r", "/simulated_plant/load_to:=/hands/load_to"]
    plant = [sys.executable, "-m", "flatplank_sim.nodes.simulated_plant", "--ros-args", *options]
    with nodes, open(log, "ab") as out:
        process = subprocess.Popen(
            [*plant, "--params-file", str(parameters)], stdout=out, stderr=out
        )
        try:
            yield [*nodes.nodes(), "simulated_plant"]
        finally:
            process.terminate()
            process.wait()


def test_a_campaign_asks_goes_on_and_is_stopped(visitor, observer, tmp_path):
    who = visitor()
    wait_for(lambda: "nobody" in who.page.locator("header").text_content(), 20.0, "charge is free")
    who.take()
    if observer.running:
        who.click("Stop bench")
        wait_for(lambda: not observer.running, 60.0, "the bench has stopped")
    # its drive is a second commander for as long as the middleware knows it
    known = observer.client.node.count_publishers
    wait_for(lambda: known("/bus/outputs") == 0, 60.0, "the bench before is gone from the graph")
    with bench_by_hand(tmp_path) as names:
        observer.client.wait_connected(names, 120.0)
        who.word_is("bench", "running", 60.0)
        who.tab("Measure")
        who.fill("Folder below the data folder", "by_hand")
        who.choose("Plan", "short")
        who.click("Start campaign")
        prompt = who.page.locator(".fp-prompt")
        for text in ("turn the plank switch to stop", "lift the wheel off the road"):
            wait_for(lambda text=text: prompt.text_content() == text, 180.0, text)
            assert prompt.is_visible()
            if text.startswith("turn"):
                who.click("Done, go on")
        who.tab("Machine")
        who.click("Plank forward")
        observer.fresh()
        observer.wait(lambda: observer.latest["encoders"].plank_moving, 20.0, "the plank moves")
        who.tab("Measure")
        who.click("Stop measurement")
        end = "cancelled; turn the plank switch to stop"
        who.page.get_by_text(end, exact=True).wait_for(timeout=15_000)
        assert not prompt.is_visible()
        who.click("Hand back")
        who.button("Take charge").wait_for()


def test_the_lab_is_started_with_its_interface_and_bus_file(visitor):
    """And nothing starts when they are wrong."""
    who = visitor()
    wait_for(lambda: "nobody" in who.page.locator("header").text_content(), 20.0, "charge is free")
    who.take()
    assert who.page.get_by_label("Simulated tire", exact=True).is_visible()
    who.choose("Kind", "Lab")
    who.page.get_by_label("Simulated tire", exact=True).wait_for(state="hidden")
    who.fill("Bus file", "../outside.yaml")
    who.click("Start bench")
    who.said("outside the data folder")
    who.fill("Bus file", "bench")
    who.click("Start bench")
    who.said("is not known")
    who.click("Hand back")
    who.button("Take charge").wait_for()
