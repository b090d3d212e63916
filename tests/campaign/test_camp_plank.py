# SPDX-License-Identifier: Apache-2.0
"""Runs with a driven plank: its drive makes what the switch asks for."""

from __future__ import annotations

import numpy as np
import pytest
from camp_plans import LENIENT, ROAD, small

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign import Conductor, Journal
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.moves import SPEED
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import PlanFailed, Wait
from flatplank_data.campaign import Campaign
from flatplank_hw.cia402 import State
from flatplank_sim.twin.campaign import run_on_twin
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

SETUP = BenchSetup(pace="hold", axes=("plank",))


def bench_in(folder) -> TwinBench:
    bench = TwinBench(Twin(SETUP), TableLog(folder))

    def refuse(*_words):
        raise AssertionError("a driven plank has no switch")

    bench.twin.plant.operator.plank = refuse
    return bench


@pytest.mark.parametrize("kind", ["slip", "free_rolling", "stiffness_longitudinal"])
def test_a_run_is_made_with_the_driven_plank(kind, tmp_path):
    bench = bench_in(tmp_path)
    m = Measurement(measurement=kind, kappa=-0.05, step_position=0.1, end_position=0.5)
    for _ in range(2):
        bench.perform(plan_of(m))
    table = Campaign.load(tmp_path).runs[-1].table()
    x, v = table["plank_position"], table["plank_velocity"]
    if kind == "slip":
        rolling = (x > 0.05) & (x < 0.49)
        assert np.mean(v[rolling]) == pytest.approx(SPEED, rel=2e-3)
        assert np.mean(table["fx"][x > 0.45]) < -1500.0
    plank = bench.twin.axes["plank"].sample
    assert plank.state != State.OPERATION_ENABLED and plank.stop_reason == 0


def test_a_run_that_fails_leaves_the_plank_at_rest(tmp_path):
    bench = bench_in(tmp_path)

    def broken():
        for step in plan_of(Measurement(step_position=0.1, end_position=0.5)):
            if isinstance(step, Wait) and step.may_end_early:
                yield Wait("never", lambda _s: False, 3.0)
            yield step

    with pytest.raises(PlanFailed, match="never"):
        bench.perform(broken())
    moved = bench.twin.plant.truth.plank_position
    bench.advance(50)
    still = bench.twin.plant.truth.plank_position
    bench.advance(50)
    assert moved > 0.05 and bench.twin.plant.truth.plank_position == still


def test_a_campaign_on_the_twin_drives_what_it_is_given(tmp_path):
    plan = small(ROAD + LENIENT, runs="runs:\n- {measurement: slip, kappa: 0.05, start: 1}\n")
    journal = Journal(tmp_path / "j.jsonl", plan.name, plan.digest)
    run_on_twin(Conductor(plan, journal), SETUP, tmp_path)
    runs = Campaign.load(tmp_path).runs
    assert [run.info.measurement for run in runs] == ["free_rolling", "slip"]
