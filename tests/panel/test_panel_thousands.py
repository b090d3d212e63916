# SPDX-License-Identifier: Apache-2.0
"""A page gets one page of a long list, in the order and with the words that were asked for."""

from __future__ import annotations

import shutil

import pytest
from made_up import campaign
from test_panel_export import rows_of, saved

from flatplank_panel.views.run_list import natural

REPEATS = 100
"""of each of three slips"""


def test_runs_are_sorted_as_people_count():
    names = ["run_10", "run_9", "Run_1", "run_9b", ""]
    assert sorted(names, key=natural) == ["", "Run_1", "run_9", "run_9b", "run_10"]
    assert sorted([10, 9, 0], key=natural) == [0, 9, 10]


@pytest.fixture
def many(data):
    yield campaign(data / "many", repeats=REPEATS, rate=2.0)
    shutil.rmtree(data / "many")


@pytest.mark.browser
def test_a_long_list_is_paged_sorted_and_filtered_on_the_server(visitor, many):
    who = visitor()
    who.tab("Runs")
    who.choose("Campaign", "many (300 runs)")
    who.page.get_by_text("1-12 of 300").wait_for()
    names = who.page.locator(".fp-table tbody td:nth-child(2)")
    who.page.get_by_text("The first 60 of 300 runs are drawn.").wait_for()
    assert names.count() == 12
    who.page.get_by_role("columnheader", name="Order").click()
    who.page.get_by_role("columnheader", name="Order").click()  # the second click turns it round
    who.page.locator(".fp-table tbody tr:first-child").get_by_text("_100.parquet").wait_for()
    who.page.get_by_role("button", name="Last page").click()
    who.page.get_by_text("289-300 of 300").wait_for()
    assert "-5perc" in names.last.text_content()
    who.page.get_by_label("Select TOY_REL_LNG_-5perc_T_p25_Fz3700_1.parquet").click()
    who.page.get_by_text("The first 60").wait_for(state="hidden")
    who.page.get_by_label("Filter runs").fill("2perc")
    who.page.get_by_text("1-12 of 100").wait_for()
    listed = rows_of(saved(who, "Save the list as a table"))
    assert len(listed) == REPEATS and [row["Order"] for row in listed][:2] == ["199", "198"]
    assert not who.errors
