# SPDX-License-Identifier: Apache-2.0
"""Runs as the fits see them: model inputs, slip travel, the start at a slip angle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from idn_runs import X, run

from flatplank_analysis.identify.lateral import lateral_run
from flatplank_analysis.identify.runs import actual_slip, by_level, by_operating_point, step_run
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable


def test_inputs_of_the_model_from_a_run():
    alpha = 0.1
    bare = run(0.02, alpha=alpha, gamma=0.03, distance=X + 0.01)
    x = np.array([0.1, 0.4, 3.0])
    found = bare.inputs_at(x, -5.0)
    travel = np.array([0.1, 0.3, 2.6])
    np.testing.assert_allclose(found.travel[0], travel * np.cos(alpha))
    np.testing.assert_allclose(found.slip_y[0], travel * np.sin(alpha))
    # beyond the end of the record the slip goes on
    assert found.slip_x.sum() == pytest.approx(0.02 * 3.0, rel=0.01)
    assert (found.start_fx[0], found.start_fy[0]) == (-5.0, 0.0)
    assert (found.alpha[0, 1], found.gamma[0, 2], found.pressure[0, 0]) == (alpha, 0.03, 250e3)
    assert bare.inputs(0.01).shape[1] == pytest.approx(251, abs=1)
    centres, (means,) = bare.grid(0.01, bare.fx[None])
    np.testing.assert_allclose(np.cumsum(bare.inputs(0.01).travel[0]), centres * np.cos(alpha))
    assert centres[0] == pytest.approx(0.005)
    np.testing.assert_allclose(means, np.interp(centres, bare.distance, bare.fx), atol=1.0)
    with pytest.raises(FlatplankError, match="pressure not stated"):
        replace(bare, pressure=np.nan).inputs_at(x)
    fz = np.where(X < 0.0, 9e3, 3000.0)
    assert run(fz=fz).mean_load == 3000.0
    slip = 0.02 * np.cos(alpha) * X + np.where(X < 0.02, 0.3, 0.0)
    assert actual_slip(X, slip, alpha) == pytest.approx(0.02)
    # a saw of 0.1 mm is smoothed away
    saw = 1e-4 * (np.arange(len(X)) % 10) / 10.0
    rough = run(0.02, slip=0.02 * np.maximum(X, 0.0) + saw)
    steps = rough.inputs_at(X[X > 0.3]).slip_x[0][1:]
    assert np.ptp(steps) < 0.2e-5
    runs = [run(0.02, name="b"), run(-0.01, name="a"), run(0.02, name="c")]
    assert [[r.name for r in g] for g in by_level(runs).values()] == [["a"], ["b", "c"]]
    assert list(by_operating_point(runs)) == ["one"]


def lateral_table(alpha_deg: float, kappa: float = 0.01, step: float = 1.5, end: float = 3.0):
    """Rest, then a run at a slip angle with a slip step."""
    x = np.concatenate([np.zeros(40), np.arange(0.0, end, 0.001)])
    after = x > step
    columns = {
        "plank_position": x + 0.2,
        "fy": -800.0 * -np.expm1(-x / 0.3),
        "fx": 25.0 + 700.0 * after + 900.0 * ((x > step + 0.3) & (x < end - 0.31)),
        "mz": 12.0 * (x > 0.5),
        "fz": np.full_like(x, 3700.0),
    }
    info_ = RunRecord("a.parquet", kappa=kappa, fz=3700.0, pressure=2.4, alpha_deg=alpha_deg,
                    gamma_deg=1.5, start=3, step_position=0.2 + step)  # fmt: skip
    return MeasurementTable(columns, info_)


def test_a_start_at_a_slip_angle_is_a_step_in_side_slip():
    found = lateral_run(lateral_table(3.0))
    assert found.kappa == pytest.approx(math.tan(math.radians(3.0))) and found.level == 3.0
    assert found.distance[0] == pytest.approx(0.0, abs=0.003)
    assert found.distance[-1] == pytest.approx(1.5 * math.cos(math.radians(3.0)), abs=0.004)
    middle = np.searchsorted(found.distance, 0.6)
    x = found.distance[middle] / math.cos(math.radians(3.0))
    assert found.fx[middle] == pytest.approx(800.0 * -math.expm1(-x / 0.3), rel=0.01)
    assert (found.fy[middle], found.mz[middle]) == pytest.approx((25.0, 12.0))
    np.testing.assert_allclose(found.slip, found.kappa * found.distance)
    assert (found.pressure, found.start) == (2.4e5, 3) and found.alpha == 0.0
    assert found.gamma == pytest.approx(math.radians(1.5))
    # last 0.3 m less 0.3 m before the step, over the slip
    assert found.slip_stiffness == pytest.approx(700.0 / 0.01)
    for changed in (lateral_table(3.0, kappa=0.03), lateral_table(3.0, end=2.05),
                    lateral_table(3.0, kappa=0.0)):  # fmt: skip
        assert math.isnan(lateral_run(changed).slip_stiffness)
    assert lateral_run(lateral_table(3.0, kappa=0.0)).distance[-1] > 2.9
    with pytest.raises(FlatplankError, match="does not move"):
        still = lateral_table(3.0)
        columns = {k: v for k, v in still.columns.items() if k != "plank_position"}
        lateral_run(MeasurementTable({**columns, "plank_position": 0.0 * still["fx"]}, still.info))


def coarse(**more) -> MeasurementTable:
    """Samples every 80 mm, a slip step at 1 m; Fx 30 N before it, 930 N in the last 0.3 m."""
    x = 0.08 * np.arange(27)
    fx = np.where(x < 0.7, 7.0, np.where(x < 1.0, 30.0, np.where(x > 1.78, 930.0, 400.0)))
    facts = {"kappa": 0.02, "fz": 3700.0, "pressure": 2.4, "alpha_deg": 3.0, "step_position": 1.0}
    columns = {"plank_position": x, "fx": fx, "fy": -x, "fz": 0.0 * x + 3700.0}
    return MeasurementTable(columns, RunRecord("a.parquet", **(facts | more)))


def test_the_road_moves_from_the_first_sample_beyond_half_a_millimetre():
    cell = 0.08 * math.cos(math.radians(3.0))
    found = lateral_run(coarse(kappa=0.0), spacing=cell)
    np.testing.assert_allclose(found.distance, cell * np.arange(26), atol=1e-12)
    np.testing.assert_allclose(found.fx, 0.08 * np.arange(1, 27))
    # up to the step
    np.testing.assert_allclose(lateral_run(coarse(), cell).fx, 0.08 * np.arange(1, 13))


def test_slip_travel_counts_from_the_step():
    """Before it the wheel may lag: kappa and the travel at the step do not see it."""
    x = np.arange(0.0, 3.0, 0.001)
    after = np.maximum(x - 1.0, 0.0)
    angle = (x + 0.02 * after - 0.004 * np.minimum(x, 1.0) + 0.7) / 0.31
    columns = {"plank_position": x, "wheel_angle": angle, "fx": 1e3 * x, "fz": 0.0 * x + 3e3}
    facts = {"kappa": 0.02, "fz": 3e3, "pressure": 2.2, "alpha_deg": 4.0, "gamma_deg": -1.0}
    info_ = RunRecord(
        "a.parquet", step_position=1.0, effective_rolling_radius=0.31, start=2, **facts
    )
    found = step_run(MeasurementTable(columns, info_))
    cos = math.cos(math.radians(4.0))
    assert np.interp(0.0, found.distance, found.slip) == pytest.approx(0.0, abs=1e-9)
    inner = found.distance[(found.distance > 0.01) & (found.distance < 1.98)]
    np.testing.assert_allclose(
        np.interp(inner, found.distance, found.slip), (1.02 - cos) * inner, atol=2e-5
    )
    assert found.kappa == pytest.approx((1.02 - cos) / cos, rel=1e-3)
    assert found.distance[0] == pytest.approx(-0.3, abs=0.003)
    np.testing.assert_allclose(found.fx[5:-5], 1e3 * (1.0 + found.distance[5:-5]), atol=1e-6)
    assert not found.fy.any() and not found.mz.any() and found.mean_load == 3e3
    assert (found.alpha, found.gamma) == pytest.approx((math.radians(4.0), -math.radians(1.0)))
    assert found.pressure == pytest.approx(2.2e5)
    assert (found.start, found.level, found.name) == (2, 0.02, info_.name)
