# SPDX-License-Identifier: Apache-2.0
"""The campaign path of the plant against the bench, and against itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plant_rig import QUIET, Rig

from flatplank_sim.plant import PlantConfig
from flatplank_sim.plant.campaign import Campaign, CampaignRun


def test_a_run_of_the_campaign_path_equals_the_bench() -> None:
    config = PlantConfig.load(overrides=QUIET)
    campaign = Campaign(config)
    run = CampaignRun(
        kappa=0.05,
        effective_rolling_radius=0.31088,
        step_position=0.8,
        length=2.0,
        start_delay=0.0355,
    )
    (table,) = campaign.simulate([run])
    rig = Rig()
    rig.plant.operator.axle_height(0.318 - 3700.0 / 2.13e5)
    rig.run(8.0)
    rig.enable()
    rig.record = True
    rig.plant.operator.plank(1, fast=True)
    per_count = 2.0 * math.pi * 0.05 / 20000.0
    while rig.plant.truth.road_position < 2.0:
        x = rig.inputs.plank_counts * per_count
        kappa = 0.05 if x - 0.02 >= 0.8 else 0.0
        rig.wheel_velocity(0.03092 * (1.0 + kappa) / 0.31088 if x > 0.0 else 0.0)
        rig.run(0.004)
    x = rig.column("road_position")
    other = np.interp(x, table["road_position"], table["fx_true"])
    # the servo starts ideally in the campaign path; what that leaves behind rolls out
    difference = np.abs(other - rig.column("fx"))
    assert difference[x > 0.05].max() < 15.0
    assert difference[x > 1.3].max() < 2.0
    k = x > 1.3
    wheel = np.interp(x, table["road_position"], table["wheel_velocity"])
    assert wheel[k] == pytest.approx(rig.column("wheel_velocity")[k], rel=1e-4)
    torque = np.interp(x, table["road_position"], table["motor_torque"])
    assert torque[k] == pytest.approx(rig.column("motor_torque")[k], abs=0.03)


def test_half_the_step_hardly_changes_a_run_of_the_campaign_path() -> None:
    config = PlantConfig.load(overrides=QUIET)
    run = CampaignRun(kappa=0.05, length=1.5, step_position=0.8)
    fx = []
    for step in (0.008, 0.004):
        (table,) = Campaign(config, tire_step=step).simulate([run])
        fx.append(np.interp(np.linspace(0.1, 1.4, 400), table["road_position"], table["fx_true"]))
    assert np.abs(fx[0] - fx[1]).max() < 3.0


def test_a_lag_of_the_forces_is_the_same_at_any_rate() -> None:
    defects = QUIET["defects"] | {"force_lag": {"time": 0.06}}
    config = PlantConfig.load(overrides={"defects": defects})
    run = CampaignRun(kappa=0.05, length=1.2, step_position=0.8)
    # behind the step itself, which 20 samples per second do not resolve
    at = np.linspace(0.84, 1.15, 200)
    fx = []
    for rate in (20.0, 250.0):
        (table,) = Campaign(config, rate_hz=rate).simulate([run])
        late = table["fx"] - table["fx_true"]
        fx.append(np.interp(at, table["road_position"], late))
    assert np.abs(fx[1]).max() > 15.0
    assert np.abs(fx[0] - fx[1]).max() < 0.05 * np.abs(fx[1]).max()


def test_a_free_wheel_of_the_campaign_path_has_the_true_radius() -> None:
    campaign = Campaign(PlantConfig.load(overrides=QUIET))
    (table,) = campaign.simulate([CampaignRun(free=True, length=2.0)])
    k = table["road_position"] > 1.0
    radius = np.polyfit(table["wheel_angle"][k], table["road_position"][k], 1)[0]
    assert radius == pytest.approx(0.31088, rel=1e-3)
    assert table["fx_true"][-1] == pytest.approx(-44.0, abs=2.0)


def test_a_campaign_is_the_same_for_the_same_seed_and_knows_all_defects() -> None:
    campaign = Campaign(PlantConfig.load(preset="thesis2023"))
    runs = [
        CampaignRun(kappa=k, length=1.0, step_position=0.5, run_index=i)
        for i, k in enumerate((0.02, -0.02))
    ]
    one = list(campaign.simulate(runs, seed=5))
    two = list(campaign.simulate(runs, seed=5))
    for a, b in zip(one, two, strict=True):
        assert all(np.array_equal(a[key], b[key]) for key in a)
        assert all(np.isfinite(a[key]).all() for key in a)
    assert one[0]["fx"][-1] > 200.0 > -200.0 > one[1]["fx"][-1]
