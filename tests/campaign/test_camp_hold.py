# SPDX-License-Identifier: Apache-2.0
"""The benchmark of load controller and steering hold keeps what it promises."""

from __future__ import annotations

import numpy as np
import pytest
from pyarrow import parquet

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import axes_of, plan_of
from flatplank_control.runner.steps import Enable, Manual
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.bench.hold_bench import load_over_the_road, load_step, steering


def test_the_load_is_within_1_percent_through_undulation_and_braking():
    free = load_over_the_road(False, -0.1, 1.3)["worst_percent"]
    held = load_over_the_road(True, -0.1, 1.3)["worst_percent"]
    assert held < 1.0 < free


@pytest.mark.parametrize("tire", ["toyo", "racing"])
def test_no_overshoot_over_2_percent(tire):
    found = load_step(2000.0, 3700.0, tire)
    assert found["overshoot_percent"] < 2.0
    assert abs(found["end_percent"]) < 0.5


@pytest.mark.parametrize("way", ["by_moment", "by_hub_encoder"])
def test_the_steering_is_held_against_0_2_deg_of_play(way):
    assert abs(steering("free", distance=0.8)["mean_deg"]) > 0.08
    assert steering(way, distance=0.8)["worst_deg"] < 0.03


def test_a_run_of_a_plan_has_its_load_held(tmp_path):
    """The controller takes the axle before the road moves and leaves it to the operator after."""
    m = Measurement(kappa=-0.1, step_position=0.1, end_position=0.35, hold_load=True,
                    effective_rolling_radius=0.3109)  # fmt: skip
    plant = tmp_path / "plant.yaml"
    plant.write_text("defects: {load_change: {brake: 0.0097, drive: 0.004}}\n")
    setup = BenchSetup(pace="hold", axes=axes_of(m), plant_file=str(plant))
    bench = TwinBench(Twin(setup), TableLog(tmp_path))
    bench.perform([*plan_of(m), Enable(False), Manual("unload", 0.0)])
    table = parquet.read_table(bench.kept[0]).to_pydict()
    fz = np.convolve(table["fz"], np.ones(25) / 25, "valid")
    assert min(table["fx"]) < -1500.0
    assert np.abs(fz / 3700.0 - 1.0).max() < 0.01
    assert bench.twin.plant.truth.fz == 0.0
