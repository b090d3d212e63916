# SPDX-License-Identifier: Apache-2.0
"""Settings of a plan beside slip and load: plank speed, direction, start angle, camber of the hub,
flexplates. On the twin, and as every proposed next run.
"""

from __future__ import annotations

import numpy as np
import pytest
from camp_plans import small

from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.bench.results import write_campaign
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign import PlanError
from flatplank_control.runner.dry_run import dry_run
from flatplank_control.runner.measurement import Measurement, MeasurementError
from flatplank_control.runner.plans import plan_of
from flatplank_data.campaign import Campaign
from flatplank_panel.next_plan import block_of
from flatplank_sim.plant import PlantConfig
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.truth import truth_row


def measured(m: Measurement, folder):
    """The run's table, and the twin after it."""
    bench = TwinBench(Twin(BenchSetup(pace="hold")), TableLog(folder))
    bench.perform(plan_of(m))
    write_campaign(folder, m.tire, [(m.record(), bench.kept[0].name)])
    (run,) = Campaign.load(folder).runs
    return run.table(), bench.twin


def test_a_slow_run_is_no_repeat_of_a_fast_one(tmp_path):
    m = Measurement(kappa=0.05, speed=0.0015, step_position=0.05, end_position=0.15)
    table, _ = measured(m, tmp_path)
    rolling = table["plank_position"] > 0.02
    assert np.median(table["plank_velocity"][rolling]) == pytest.approx(0.0015, rel=0.02)
    assert table["fx"].max() > 800.0
    assert table.info.speed == 0.0015
    fast = Measurement(kappa=0.05).record()
    assert fast["speed"] is None
    assert table.info.condition.measurement == "slip slow"


def test_a_wheel_off_its_drive_tells_the_rolling_radius(tmp_path):
    m = Measurement(measurement="free_rolling", flexplates=False, end_position=2.0)
    table, twin = measured(m, tmp_path)
    found = radius_of_run(table)
    assert found.source == "flexplates_off"
    truth = truth_row(PlantConfig.load("toyo"), m.fz, m.pressure)
    at_zero = found.corrected(truth.slip_stiffness)
    assert at_zero == pytest.approx(truth.effective_rolling_radius, rel=1e-3)
    # its own resistance brakes it
    assert -100.0 < found.force < 0.0
    assert twin.plant.operator.view.flexplates


def test_a_held_wheel_goes_back(tmp_path):
    m = Measurement(measurement="locked_wheel", direction="reverse", distance=0.05)
    table, _ = measured(m, tmp_path)
    x = table["plank_position"]
    assert x[-1] - x[0] == pytest.approx(-0.053, abs=0.004)
    # the road that comes back pushes the wheel forward
    assert table["fx"].max() > 3000.0


def test_hub_and_road_share_the_camber(tmp_path):
    m = Measurement(gamma_deg=5.0, wheel_camber_deg=3.0, step_position=0.2, end_position=0.8)
    table, twin = measured(m, tmp_path)
    assert np.degrees(np.median(table["road_camber"])) == pytest.approx(2.0, abs=0.05)
    assert np.degrees(np.median(table["total_camber"])) == pytest.approx(5.0, abs=0.05)
    assert twin.hub.parameters.wheel_camber_deg == 3.0


def test_a_start_between_the_usual_ones(tmp_path):
    m = Measurement(start_angle_deg=60.0, step_position=0.2, end_position=0.8)
    table, twin = measured(m, tmp_path)
    assert np.degrees(table.info.start_angle) == pytest.approx(60.0)
    assert np.degrees(twin.latest.encoders.wheel_angle) > 60.0
    assert Measurement(start=3).start_angle == 240.0


@pytest.mark.parametrize(
    ("wrong", "key", "words"),
    [
        ({"speed": 0.01}, "speed", "0.03092 and 0.0015"),
        ({"direction": "back"}, "direction", "forward or reverse"),
        ({"direction": "reverse"}, "direction", "only a held wheel goes back"),
        ({"flexplates": False}, "flexplates", "can only roll freely"),
        ({"start_angle_deg": 400.0}, "start_angle_deg", "-360 .. 360"),
    ],
)
def test_what_cannot_be_is_refused_with_its_key(wrong, key, words):
    with pytest.raises(MeasurementError, match=words) as refused:
        Measurement(**wrong)
    assert refused.value.key == key


def test_a_road_that_would_tilt_too_far_is_refused_in_the_dry_run():
    runs = "runs:\n- measurement: slip\n  gamma_deg: 20\n  kappa: 0.0\n"
    with pytest.raises(PlanError, match="road_camber_deg is 20 deg, must be within -15 .. 15"):
        small(runs=runs)
    assert dry_run(small(runs=runs + "  wheel_camber_deg: 8\n")).total > 0.0


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ({"speed": 0.0015}, {"speed": 0.0015}),
        ({"start": 1.5}, {"start_angle_deg": 60.0}),
        ({"start": 2}, {"start": 2}),
    ],
)
def test_every_proposed_setting_is_a_plan(setting, said):
    block = block_of({"kappa": 0.01, "step_position": 1.5, **setting})
    assert said.items() <= block.items()
    Measurement(**block)
