# SPDX-License-Identifier: Apache-2.0
"""The floor in the report: what turns with the wheel is no noise, and no model beats the floor by
more than chance."""

import numpy as np
import pytest

from flatplank_analysis.report.conditions import condition_result
from flatplank_analysis.report.floors import share_in_mean
from flatplank_analysis.report.models import linear_curves

NOISE = 8.0
"""[N] white at 20 samples per second"""
STARTS = {
    "three starts": (1, 2, 3),
    "three of each": (1, 2, 3) * 3,
    "one more often": (1, 1, 1, 1, 1, 2, 3),
    "one start": (1, 1, 1, 1),
}


def _condition(make_step, kappa: float, starts: tuple[int, ...], turning: float, seed: int):
    """A condition with a known response, noise, and a force that turns with the wheel [N]."""
    random = np.random.default_rng(seed)
    tables = []
    for start in starts:
        table = make_step(kappa, start)
        angle = table["wheel_angle"] + table.info.start_angle
        wave = turning * (np.cos(angle + 0.4) + 0.3 * np.sin(2.0 * angle))
        noise = NOISE * random.normal(size=len(table))
        tables.append(table.with_columns(fx=table["fx"] + wave + noise))
    return condition_result(tables[0].info.condition, tables)


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.parametrize("turning", (0.0, 120.0))
def test_no_model_beats_the_floor_by_more_than_chance(name, turning, make_step):
    """The response is that of the linear model: its error is that of the mean."""
    starts = STARTS[name]
    if turning and len(set(starts)) == 1:
        turning = 0.0  # from one start, nothing cancels: the wave is no scatter but an error
    slips = (0.01, -0.02, 0.05, -0.1)
    found = [_condition(make_step, k, starts, turning, 10 + i) for i, k in enumerate(slips)]
    errors = linear_curves(found).rmse
    ratios = [errors[c.condition] / c.floor() for c in found]
    assert 0.8 < float(np.sqrt(np.mean(np.square(ratios)))) < 1.25, ratios
    for c in found:
        assert c.floor() == pytest.approx(c.run_floor * share_in_mean(starts))


def test_what_turns_with_the_wheel_is_no_part_of_the_floor(make_step):
    still, turning = (_condition(make_step, 0.05, (1, 2, 3), size, 3) for size in (0.0, 120.0))
    assert turning.max_scatter() > 5.0 * still.max_scatter()
    assert turning.run_floor == pytest.approx(still.run_floor, rel=0.1)


def test_one_run_has_no_floor(make_step):
    assert np.isnan(_condition(make_step, 0.05, (1,), 0.0, 4).floor())


def test_the_mean_counts_every_start_once():
    assert share_in_mean((1, 2, 3)) == pytest.approx(3.0**-0.5)
    assert share_in_mean((1, 1, 1, 1)) == pytest.approx(0.5)
    assert share_in_mean((1, 1, 2)) == pytest.approx(np.sqrt(0.5 + 1.0) / 2.0)
