# SPDX-License-Identifier: Apache-2.0
"""A plate with play stays where a run leaves it: the next one starts from there."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from flatplank_analysis.contact_patch.data import load_runs
from flatplank_analysis.contact_patch.laws import play_position
from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.tire_runs import side_before
from flatplank_analysis.effects.registry import library
from flatplank_analysis.inference.search import run_search
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import Campaign
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

GAP, SOFT, HOLD = 1e-3, 0.01, 20.0


@njit
def _places(forces, play, soft, hold, last):
    out = np.empty((2, len(forces)))
    for i in range(len(forces)):
        out[0, i], out[1, i] = play_position(forces[i], play, 0.0, soft, hold, last)
        last = out[0, i]
    return out


def test_the_side_is_that_of_the_last_slip():
    order, kappa = np.array([3.0, 1.0, 2.0, 5.0, 4.0]), np.array([0.0, 0.02, -0.01, 0.1, -0.05])
    np.testing.assert_array_equal(side_before(order, kappa), [-1.0, 0.0, 1.0, -1.0, -1.0])


def test_friction_holds_the_plate_until_the_force_is_beyond_it():
    up = np.array([0.0, 15.0, 25.0, 5.0, -15.0, -25.0, 0.0, 15.0])
    half = 0.5 * GAP
    places, rates = _places(up, GAP, SOFT, HOLD, -half)
    wanted = np.array([-half, -half, half, half, half, -half, -half, -half])
    np.testing.assert_allclose(places, wanted, atol=1e-5 * GAP)
    assert np.all(rates >= 0.0)


def test_without_friction_the_place_goes_with_the_force_alone():
    forces = np.array([0.0, 8.0, -8.0, 0.0])
    first, second = (_places(forces, GAP, 10.0, 0.0, at) for at in (-0.3 * GAP, 0.5 * GAP))
    np.testing.assert_array_equal(first, second)
    x = forces / 10.0
    np.testing.assert_allclose(first[0], 0.5 * GAP * x / np.sqrt(1.0 + x**2))
    step = _places(forces + 1e-4, GAP, 10.0, 0.0, 0.0)[0] - first[0]
    np.testing.assert_allclose(step / 1e-4, first[1], rtol=1e-3)


@pytest.mark.long
def test_play_is_found_where_repeats_begin_on_either_side(tmp_path):
    """One bench for all runs, as in the lab: after a braking run the gap is open the other way,
    and repeats of one condition differ by 100 N. The plant is the only one that knows why."""
    plant = tmp_path / "plant.yaml"
    plant.write_text(f"defects: {{road_play: {{gap: {GAP}, friction: 20.0}}}}\n")
    runs = tmp_path / "runs"
    runs.mkdir()
    setup = BenchSetup(pace="hold", seed=2291, plant_file=str(plant))
    bench = TwinBench(Twin(setup), TableLog(runs))
    for i, kappa in enumerate([0.05, -0.05, -0.05, 0.05, 0.02, 0.02, -0.05, 0.02]):
        bench.perform(plan_of(Measurement(
            name=f"run_{i}", kappa=kappa, start=1 + i % 3, run_index=i + 1, step_position=0.8,
            end_position=2.4,
        )))  # fmt: skip
    search = run_search(TireModel(load_runs(Campaign.load(runs))), list(library().values()))
    before, after = (s.state.runs.rmse(s.state.residual[0]) for s in search.steps)
    (found,) = search.last.found
    low, high = found.decision.interval
    assert found.decision.term.effect.identifier == "road_play" and not found.alike
    assert low < GAP < high < 1.3 * GAP and before > 25.0 and after < 6.0
