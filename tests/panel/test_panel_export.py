# SPDX-License-Identifier: Apache-2.0
"""What is seen can be taken along: the points of a chart and the list of runs as CSV, a chart as
PNG."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from panel_rig import shows, status, wait_for

pytestmark = pytest.mark.browser
CHART = "e => getElement(Number(e.id.slice(1))).chart"
CSV, PNG = "Save the points that are seen as a table", "Save the chart as a picture"


def saved(who, label: str, at: str = "body") -> Path:
    """The file that a button below `at` gives."""
    with who.page.expect_download() as download:
        who.page.locator(at).get_by_role("button", name=label).filter(visible=True).first.click()
    return Path(download.value.path()).rename(
        Path(download.value.path()).with_name(download.value.suggested_filename)
    )


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_points_in_view_and_no_others(visitor, made_up):
    who = visitor()
    who.tab("Runs")
    who.choose("Campaign", "made_up (9 runs)")
    chart = who.page.get_by_role("img", name="Fx [N] over road displacement [m]")
    chart.wait_for()
    who.page.wait_for_function(
        "e => getElement(Number(e.id.slice(1))).chart?.kept", arg=chart.element_handle()
    )
    whole = rows_of(saved(who, CSV))
    assert {row["curve"] for row in whole} == {"κ -5 %", "κ +2 %", "κ +5 %"}
    assert {(r["x_axis"], r["y_axis"]) for r in whole} == {("road displacement [m]", "Fx [N]")}
    assert min(float(r["x"]) for r in whole) < 0.1 and max(float(r["x"]) for r in whole) > 4.0
    chart.evaluate(f"e => ({CHART})(e).dispatchAction({{type: 'dataZoom', start: 50, end: 60}})")
    chart.evaluate(f"e => ({CHART})(e).dispatchAction({{type: 'legendUnSelect', name: 'κ -5 %'}})")
    path = saved(who, CSV)
    part = rows_of(path)
    assert path.name == "made_up_Curves.csv"
    assert {row["curve"] for row in part} == {"κ +2 %", "κ +5 %"}
    assert 2.0 <= min(float(r["x"]) for r in part) < max(float(r["x"]) for r in part) <= 3.0
    drawn = {(r["curve"], r["x"], r["y"]) for r in whole}
    assert {(r["curve"], r["x"], r["y"]) for r in part} <= drawn
    assert saved(who, PNG).read_bytes().startswith(b"\x89PNG")
    assert not who.errors


def test_the_list_of_runs_as_it_is_filtered(visitor, made_up):
    who = visitor()
    who.tab("Runs")
    who.choose("Campaign", "made_up (9 runs)")
    who.said("1-9 of 9")
    who.page.get_by_label("Filter runs").fill("-5perc")
    who.said("1-3 of 3")
    listed = rows_of(saved(who, "Save the list as a table"))
    assert [row["Slip [%]"] for row in listed] == ["-5.0"] * 3
    assert {row["Load [N]"] for row in listed} == {"3700.0"}
    assert all(row["Verdict"] == "ok" for row in listed)


def test_bars_and_cells_have_the_names_of_their_axes(visitor, made_up):
    who = visitor()
    who.tab("Discover")
    shows(who, "made_up")
    who.click("Open")
    wait_for(lambda: "beyond the floor" in status(who), 120.0, "the base is fitted")
    card = ".fp-card:has(> .fp-head:text-is('{}'))".format
    bars = rows_of(saved(who, CSV, card("Error against the floor")))
    assert {(r["curve"], r["y"]) for r in bars} == {
        (curve, condition)
        for curve in ("error", "floor of the condition")
        for condition in ("κ -5 %", "κ +2 %", "κ +5 %")
    }
    assert all(float(r["x"]) > 0.0 and r["x_axis"] == "RMS error of Fx [N]" for r in bars)
    cells = rows_of(saved(who, CSV, card("Where the error is")))
    assert {r["y"] for r in cells} == {r["y"] for r in bars}
    assert max(abs(float(r["value"])) for r in cells) > 10.0
    assert {r["curve"] for r in cells} == {"measured minus model [N]"}
    pair = rows_of(saved(who, CSV, card("Measured and model")))
    assert {(r["curve"], r["y_axis"]) for r in pair} == {
        ("measured", "Fx [N]"), ("model", "Fx [N]"), ("residual", "residual [N]")
    }  # fmt: skip
    assert not who.errors
