# SPDX-License-Identifier: Apache-2.0
"""The page is gone, a second page, the stop button, hostile input: judged at the plant."""

from __future__ import annotations

import numpy as np
import pytest
from panel_rig import PATIENT, wait_for
from playwright.sync_api import Error

from flatplank_panel.views.shell import NOBODY

pytestmark = [pytest.mark.browser, pytest.mark.graph]


def turn(who, observer) -> None:
    who.tab("Drive")
    who.fill("Velocity [rad/s]", 0.08)

    def click() -> None:
        who.click("Reset fault")
        who.click("Enable")
        who.page.wait_for_timeout(500)
        who.click("Set velocity")

    click()
    observer.wait(lambda: observer.speed() > 0.06, 60.0, "the shaft turns", again=click)


def pause_beats(who, observer) -> None:
    """Long enough for the drive to drop the claim, while nothing moves."""
    observer.fresh()
    since = observer.inputs.stamp_ns
    who.page.evaluate("fp.charge(false)")
    pause = 1e9 * (PATIENT["heartbeat_timeout"] + 0.5)
    observer.wait(lambda: observer.inputs.stamp_ns - since > pause, 30.0, "bench time goes on")
    who.page.evaluate("fp.charge(true)")


def close(page) -> None:
    page.close()


def crash(page) -> None:
    """The process of the page dies, nothing says goodbye."""
    with pytest.raises(Error, match="crash"):
        page.goto("chrome://crash")


@pytest.mark.parametrize("end", [close, crash])
def test_wheel_stops_when_the_page_is_gone(visitor, operator, observer, end):
    operator.click("Hand back")
    operator.button("Take charge").wait_for()
    other = visitor()
    other.take()
    pause_beats(other, observer)
    turn(other, observer)
    end(other.page)
    observer.fresh()
    seen = [observer.inputs.stamp_ns]

    def rests() -> bool:
        seen.append(observer.inputs.stamp_ns)
        return abs(observer.inputs.axes[0].velocity) < 2**23 * 1425.04 * 1e-4

    observer.wait(rests, 30.0, "the shaft rests")
    # the ramp of a quick stop, and what is not seen between two images
    stopping = 0.4 + np.diff(seen).max() * 1e-9
    assert (seen[-1] - seen[0]) * 1e-9 < PATIENT["heartbeat_timeout"] + stopping
    assert not observer.enabled()
    wait_for(
        lambda: "nobody" in operator.page.locator("header").text_content(), 20.0, "charge is free"
    )
    operator.take()


def test_one_in_charge_others_watch_and_everybody_stops(visitor, enabled, observer):
    first = enabled.page.request.get(enabled.address).text()
    assert "is in charge" in first and NOBODY not in first, "from its first picture on"
    watcher = visitor()
    watcher.said("is in charge")
    watcher.tab("Drive")
    assert watcher.button("Enable").is_disabled()
    watcher.click("Take charge")
    watcher.said("ask for a hand-over")
    turn(enabled, observer)
    watcher.click("STOP")
    observer.wait(lambda: abs(observer.speed()) < 1e-3, 5.0, "the shaft rests")
    assert not observer.inputs.digital & 2
    enabled.tab("Machine")
    enabled.click("Release emergency stop")
    observer.wait(lambda: observer.inputs.digital & 2, what="emergency stop circuit closed")


def test_a_key_stops_on_the_page_of_the_bench_alone(operator, enabled, observer):
    turn(enabled, observer)
    enabled.tab("Runs")
    enabled.page.keyboard.press("Escape")
    enabled.tab("Bench")
    assert abs(observer.speed()) > 1e-3
    enabled.page.keyboard.press("Escape")
    observer.wait(lambda: abs(observer.speed()) < 1e-3, 5.0, "the shaft rests")
    enabled.tab("Machine")
    enabled.click("Release emergency stop")
    observer.wait(lambda: observer.inputs.digital & 2, what="emergency stop circuit closed")


def test_folders_stay_inside(operator, data):
    operator.tab("Measure")
    operator.fill("Folder below the data folder", "../outside")
    operator.fill("Name", "TOY_escape")
    operator.click("Start logging")
    wait_for(
        lambda: operator.page.locator(".q-notification").count(), 10.0, "the refusal is shown"
    )
    assert not list(data.parent.rglob("TOY_escape"))


def test_no_script_from_a_note(operator, data):
    bad = "<img src=x onerror='window.pwned=1'><script>window.pwned=1</script>"
    operator.tab("Measure")
    operator.fill("Folder below the data folder", "")
    operator.fill("Note", bad)
    operator.fill("Name", "TOY_<script>")
    operator.click("Start logging")
    operator.said("not a name for a measurement")
    operator.fill("Name", "TOY_noted_1")
    operator.page.get_by_text("at once, not from").click()
    operator.click("Start logging")
    operator.word_is("run", "recording")
    operator.click("Stop and save")
    operator.word_is("run", "complete")
    operator.tab("Runs")
    operator.page.get_by_text("onerror").first.wait_for(timeout=30000)
    assert operator.page.evaluate("window.pwned") is None
