# SPDX-License-Identifier: Apache-2.0
"""Pictures of every page, kept as build products; keyboard and accessibility on the way.

`FLATPLANK_PICTURES=docs/images ./flatplank test tests/panel -k "pictures or by_mouse"` makes those
of the documents.
"""

from __future__ import annotations

import pytest
from looks import looked_after, take
from panel_rig import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.graph]


def test_bench_by_keyboard(visitor):
    """Charge is taken and given back without a mouse."""
    who = visitor()
    button = who.button("Take charge")
    for _ in range(12):
        who.page.keyboard.press("Tab")
        if button.evaluate("e => e === document.activeElement"):
            break
    who.page.keyboard.press("Enter")
    who.button("Hand back").wait_for()
    who.page.keyboard.press("Enter")
    who.button("Take charge").wait_for()
    looked_after(who)


def test_stop_is_in_view_on_every_screen(visitor):
    who = visitor()
    for width in (390, 900, 1280, 1440):
        who.page.set_viewport_size({"width": width, "height": 800})
        # nothing is cut off or must be scrolled to, once the page is laid out for the new width
        who.page.wait_for_function("w => document.documentElement.scrollWidth === w", arg=width)
        box = who.button("STOP").bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= width
        assert box["y"] + box["height"] < 140


DARK = "() => document.body.classList.contains('body--dark')"


def test_every_page_is_legible_in_the_dark(visitor, made_up):
    who = visitor()
    who.page.emulate_media(color_scheme="dark")
    for width in (390, 1280):
        who.page.set_viewport_size({"width": width, "height": 900})
        who.page.wait_for_function(DARK)
        for tab in ("Bench", "Runs", "Catalogue", "Discover", "Investigate"):
            who.tab(tab)
            looked_after(who)
            who.page.wait_for_function(
                "w => document.documentElement.scrollWidth === w", arg=width
            )
    who.tab("Runs")
    who.choose("Campaign", "made_up (9 runs)")  # others may be there from other tests
    who.page.get_by_role("img", name="Fx [N] over road displacement [m]").wait_for()
    assert not who.errors


PLOTS = """() => [...document.querySelectorAll(".fp-live")].map(e =>
  getElement(Number(e.id.slice(1))).chart.getOption().grid.map(g => g.left))"""


def test_live_plots_stand_below_each_other_on_a_phone(visitor):
    who = visitor()
    who.page.wait_for_function(f"({PLOTS})().every(places => new Set(places).size === 3)")
    who.page.set_viewport_size({"width": 390, "height": 900})
    who.page.wait_for_function(f"({PLOTS})().every(places => new Set(places).size === 1)")


def test_pictures_of_bench_and_runs(operator, observer, pictures):
    operator.fill("Load [N]", 3700)
    operator.click("Set Load")
    observer.wait(
        lambda: abs(observer.latest["contact"].wrench.force.z - 3700.0) < 100.0, 60.0, "loaded"
    )
    operator.tab("Drive")
    operator.page.wait_for_timeout(1500)
    looked_after(operator)
    take(operator, pictures / "panel-bench.png")
    for tab in ("Measure", "Set-up", "Bus"):
        operator.tab(tab)
        operator.page.wait_for_timeout(300)
        looked_after(operator)
    operator.tab("Machine")
    operator.click("Lift the wheel")
    observer.wait(lambda: observer.lifted, 60.0, "lifted")


@pytest.mark.parametrize("made_up", [0.04], indirect=True)
def test_runs_are_listed_filtered_and_drawn(visitor, made_up, pictures):
    who = visitor()
    who.tab("Runs")
    who.page.get_by_role("button", name="Look for campaigns again").wait_for()
    who.page.wait_for_timeout(1000)
    who.choose("Campaign", "made_up (9 runs)")
    who.said("1-9 of 9")
    who.said("Scatter between repeats")
    drawn = "() => Object.values(window).length && document.querySelectorAll('canvas').length"
    wait_for(lambda: who.page.evaluate(drawn) >= 1, what="a chart")
    assert who.page.locator("td", has_text="<b>made up</b>").count() == 9
    who.page.get_by_label("Filter runs").fill("-5perc")
    who.said("1-3 of 3")
    looked_after(who)
    take(who, pictures / "panel-runs.png")
    assert not who.errors
