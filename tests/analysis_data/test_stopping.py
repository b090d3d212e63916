# SPDX-License-Identifier: Apache-2.0
"""A run ends where its plank begins to stop: the wheel goes on, and makes a slip of its own."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.figures.chapter6 import _smooth
from flatplank_analysis.post.motion import until_stop
from flatplank_analysis.report.analysis import COLUMNS
from flatplank_analysis.report.conditions import condition_result
from flatplank_analysis.report.steps import read_each_run, read_group
from flatplank_data.campaign import Campaign
from flatplank_data.table import MeasurementTable


def stopping(table: MeasurementTable) -> MeasurementTable:
    """The same with a plank that comes to rest over 20 samples, while Fx rises by 800 N."""
    time, x = table["time"].copy(), table["plank_position"].copy()
    rate = (x[-1] - x[0]) / (time[-1] - time[0])
    end = np.arange(1, 21) / 20.0
    part = slice(len(x) - 20, len(x))
    spacing = time[1] - time[0]
    x[part] = x[len(x) - 21] + rate * spacing * 20.0 * (end - 0.5 * end**2)
    fx = table["fx"].copy()
    fx[part] += 800.0 * end**2
    return table.with_columns(plank_position=x, fx=fx)


def test_a_run_is_kept_up_to_where_the_plank_begins_to_stop(make_step):
    whole = make_step(0.02)
    assert until_stop(whole) is whole
    cut = until_stop(stopping(whole))
    assert len(whole["time"]) - 22 <= len(cut["time"]) <= len(whole["time"]) - 16
    np.testing.assert_allclose(cut["fx"], whole["fx"][: len(cut["fx"])], atol=50.0)


def test_neither_fits_nor_repeatability_see_the_stop(write_campaign, make_step):
    plain = [make_step(0.02, start, noise=5.0) for start in (1, 2, 3)]
    runs = Campaign.load(write_campaign([stopping(t) for t in plain])).runs
    steps, _, problems = read_group(runs)
    assert not problems
    for step in steps:
        assert abs(step.fx[-1] - step.fx[-200]) < 60.0
    tables: list[MeasurementTable] = []
    assert not read_each_run(runs, lambda _, table: tables.append(table), COLUMNS)
    found = condition_result(tables[0].info.condition, tables)
    assert abs(found.measured["fx"][-1] - found.measured["fx"][-200]) < 60.0


def test_one_value_at_the_end_of_a_figure_counts_once():
    values = np.append(np.ones(400), 27.0)
    assert _smooth(values)[-1] == 2.0
    np.testing.assert_allclose(_smooth(values)[:300], 1.0)
    assert _smooth(np.ones(7)).shape == (7,)
