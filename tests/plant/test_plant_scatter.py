# SPDX-License-Identifier: Apache-2.0
"""Run-to-run scatter and torn weld of the machine of 2023, against the published numbers
(section 6.3, figures 6.22 and 6.23, table 7.1)."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from flatplank_sim.plant import Plant, PlantConfig, plant
from flatplank_sim.plant.campaign import Campaign, CampaignRun
from flatplank_validation.bench.start_bench import StartBench

GRID = np.arange(1.5, 4.1, 0.002)
PUBLISHED = {(0.01, 0.0): 41.0, (0.01, 5.0): 27.0, (0.05, 0.0): 70.0, (0.05, 5.0): 32.0}
"""slip, side slip [deg] -> largest standard deviation of ten repeats [N]"""
FACTOR = 1.6
"""two standard errors of the standard deviation of ten values, 24 %, above and below"""


@cache
def repeats(
    kappa: float, alpha_deg: float, weld: bool = False, seed: int = 0
) -> dict[str, np.ndarray]:
    """Fx and plank velocity of ten repeats from one start, on a common grid (10, positions)."""
    torn = {"torn_weld": {}} if weld else {}
    plant = Campaign(PlantConfig.load(preset="thesis2023", overrides={"defects": torn}))
    rows: dict[str, list[np.ndarray]] = {"fx": [], "plank_velocity": []}
    for i in range(10):
        run = CampaignRun(kappa=kappa, alpha=math.radians(alpha_deg), run_index=i)
        made = plant.run(run, np.random.default_rng((seed, i)))
        for name, found in rows.items():
            found.append(np.interp(GRID, made["plank_position"], made[name]))
    return {name: np.array(found) for name, found in rows.items()}


def largest(kappa: float, alpha_deg: float, weld: bool = False) -> tuple[float, float, float]:
    """Largest standard deviation of the repeats [N], over the largest force, and its place [m];
    mean over three sets of ten."""
    found = []
    for seed in range(3):
        force = repeats(kappa, alpha_deg, weld, seed)["fx"]
        spread = force.std(axis=0, ddof=1)
        found.append(
            (spread.max(), spread.max() / force.mean(axis=0).max(), GRID[spread.argmax()])
        )
    size, share, place = np.mean(found, axis=0)
    return float(size), float(share), float(place)


@pytest.mark.parametrize("condition", PUBLISHED)
def test_ten_repeats_scatter_as_published(condition):
    assert PUBLISHED[condition] / FACTOR < largest(*condition)[0] < PUBLISHED[condition] * FACTOR


def test_small_slips_scatter_less_in_newton_and_more_in_percent():
    """Figure 6.22: 1 % is above 3 %, 5 % is about 2 %."""
    assert largest(0.01, 0.0)[0] < largest(0.05, 0.0)[0]
    assert largest(0.01, 0.0)[1] > 0.03 > 0.025 > largest(0.05, 0.0)[1]


def test_the_mean_of_three_starts_without_slip_wavers_as_published():
    """Table 7.1: 24 N of RMSE at 0 %."""
    plant = Campaign(PlantConfig.load(preset="thesis2023"))
    forces = []
    for i in range(3):
        run = CampaignRun(start_angle=math.radians(120.0 * i), run_index=i)
        made = plant.run(run, np.random.default_rng((5, i)))
        forces.append(np.interp(GRID, made["plank_position"], made["fx"]))
    assert np.mean(forces, axis=0).std() == pytest.approx(24.0, rel=0.2)


def test_a_torn_weld_spikes_the_speed_and_drops_the_force():
    """Condition 4: a peak of 6.8 % at 1.84 m, where the measured road velocity spikes."""
    _, share, place = largest(0.05, 5.0, weld=True)
    assert share == pytest.approx(0.068, rel=0.25) and place == pytest.approx(1.84, abs=0.05)
    speed = repeats(0.05, 5.0, weld=True)["plank_velocity"]
    sound = repeats(0.05, 5.0)["plank_velocity"]
    assert (speed.max(axis=1) > 1.2 * sound.max()).all()
    where = GRID[speed.argmax(axis=1)]
    assert where.mean() == pytest.approx(1.84, abs=0.05) and np.ptp(where) > 0.005


def test_a_weld_that_is_torn_does_not_show_where_the_force_is_small():
    assert (repeats(0.01, 5.0, weld=True)["fx"] == repeats(0.01, 5.0)["fx"]).all()


def test_two_plants_of_one_seed_scatter_alike_and_two_runs_do_not():
    def errors(seed: int, run: int) -> np.ndarray:
        plant = Plant(PlantConfig.load(preset="thesis2023"), seed)
        plant.set_run(run)
        plant.step()
        return plant._records.road_map[:, 3].copy()

    assert (errors(1, 4) == errors(1, 4)).all()
    assert not (errors(1, 4) == errors(1, 5)).all() and not (errors(1, 4) == errors(2, 4)).all()


@pytest.mark.parametrize("kappa", (-0.1, 0.1))
def test_no_delay_of_a_step_is_taken_for_a_drive_that_does_not_follow(kappa, monkeypatch):
    """The drive is allowed to react late; the catch-up of the start ends without a delay."""

    def longest(records, state, _random):
        state["step_delay"] = records.machine[0]["scatter_delay"]

    monkeypatch.setattr(plant, "draw_run", longest)
    bench = StartBench(preset="thesis2023", sequencer={"follow_until": 0.25})
    rows = bench.slip(5550.0, kappa, at=0.3, distance=0.45)
    assert bench.stop_reason == 0
    late = rows[rows[:, 0] > 0.4, 2]
    assert late.mean() == pytest.approx(kappa, abs=0.02)
    before = rows[(rows[:, 0] > 0.28) & (rows[:, 0] < 0.3), 2]
    assert abs(before.mean()) < 0.02
