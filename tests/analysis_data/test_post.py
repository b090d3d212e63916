# SPDX-License-Identifier: Apache-2.0
"""Post-processing steps against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.post.frequency import frequency_response
from flatplank_analysis.post.gridding import (
    CUTOFF_PER_METRE,
    GRID,
    low_pass,
    mean_of_starts,
    on_grid,
    repeat_std,
)
from flatplank_analysis.post.motion import step_facts
from flatplank_analysis.steady.settling import fit_exponential
from flatplank_data.errors import FlatplankError


def test_grid_of_the_thesis():
    assert GRID[0] == 0.0 and GRID[-1] == 4.1 and GRID.size == 41001
    assert pytest.approx(323.4, abs=0.1) == CUTOFF_PER_METRE


def test_resampling_is_linear_interpolation_over_displacement(make_step):
    table = make_step(0.02)
    table = table.with_columns(fz=3000.0 + 100.0 * table["plank_position"])
    np.testing.assert_allclose(on_grid(table, ["fz"])["fz"], 3000.0 + 100.0 * GRID, atol=1e-6)


def test_standstill_at_the_start_is_no_problem(make_step):
    table = make_step(0.02)
    x = np.maximum(table["plank_position"] - 0.05, 0.0)
    grid = on_grid(table.with_columns(plank_position=x), ["fx"])
    assert np.isfinite(grid["fx"][:40000]).all()


def test_beyond_the_run_there_is_nothing(make_step):
    short = make_step(0.02).rows(slice(0, 2000))
    grid = on_grid(short, ["fx"])
    last = short["plank_position"][-1]
    assert np.isnan(grid["fx"][last < GRID]).all()
    assert np.isnan(low_pass(grid["fx"])[last < GRID]).all()


@pytest.mark.parametrize(("ratio", "gain"), [(0.1, 1.0), (1.0, 0.5), (4.0, 0.0)])
def test_low_pass_has_no_phase_and_halves_at_the_cutoff(ratio, gain):
    """Forward and backward: -3 dB twice at the cut-off is a half."""
    wave = np.sin(2.0 * np.pi * ratio * CUTOFF_PER_METRE * GRID)
    out = low_pass(wave)[5000:-5000]
    amplitude = 2.0 * np.mean(out * wave[5000:-5000])
    assert amplitude == pytest.approx(gain, abs=0.01)


def test_mean_of_three_starts_cancels_an_order(make_step):
    runs = []
    for start in range(3):
        table = make_step(0.0, start + 1)
        wave = 80.0 * np.sin(table["wheel_angle"] + 2.0 * np.pi * start / 3.0)
        runs.append(on_grid(table.with_columns(fx=wave), ["fx"]))
    mean = mean_of_starts(runs, [1, 2, 3])
    assert mean.runs == 3
    assert np.nanmax(np.abs(mean["fx"])) < 1e-9
    expected = 80.0 * np.sqrt(0.5) * np.sqrt(1.5)
    assert np.nanmax(np.abs(repeat_std(runs) - expected)) < 1e-3
    with pytest.raises(FlatplankError, match="no scatter"):
        repeat_std(runs[:1])


def test_actual_slip_and_load_change(make_step):
    table = make_step(0.05)
    load = np.where(table["plank_position"] > 1.5, 3650.0, 3700.0)
    facts = step_facts(table.with_columns(fz=load))
    assert facts.kappa_actual == pytest.approx(0.05, abs=1e-9)
    assert facts.kappa_before == pytest.approx(0.0, abs=1e-9)
    assert facts.load_change == pytest.approx(-50.0 / 3700.0)
    assert facts.speed_before == pytest.approx(0.031) == facts.speed_after


def test_side_slip_turns_the_travel_into_the_wheel_plane(make_step):
    table = make_step(0.0, alpha_deg=10.0)
    angle = table["wheel_angle"] * np.cos(np.radians(10.0)) * 1.02
    facts = step_facts(table.with_columns(wheel_angle=angle))
    assert facts.kappa_actual == pytest.approx(0.02, abs=1e-9)


def test_settling_distance_of_appendix_e():
    x = np.linspace(0.0, 4.2, 3000)
    noise = 15.0 * np.random.default_rng(1).normal(size=x.size)
    found = fit_exponential(x, -900.0 * np.exp(-3.8 * x) + 50.5 + noise).settles_at()
    exact = np.log(900.0 / 3.0) / 3.8
    assert found == pytest.approx(exact, rel=0.05)
    clean = fit_exponential(x, -900.0 * np.exp(-3.8 * x) + 50.5)
    assert (clean.p1, clean.p2, clean.p3) == pytest.approx((-900.0, 3.8, 50.5), rel=1e-5)
    assert clean.settles_at() == pytest.approx(exact, rel=1e-4)


def test_what_never_reaches_the_reference_does_not_settle():
    x = np.linspace(0.0, 4.2, 1000)
    assert np.isnan(fit_exponential(x, -900.0 * np.exp(-3.0 * x) + 30.0).settles_at())


@pytest.mark.parametrize("shape", ["sine", "triangle"])
def test_frequency_response_of_a_first_order_tire(shape):
    """H = C / (1 + i 2 pi s sigma), from the response integrated in small steps."""
    sigma, stiffness, wavelength = 0.4, 9e4, 1.5
    x = np.arange(0.0, 9.0, 2e-3)
    wave = np.sin(2.0 * np.pi * x / wavelength)
    if shape == "triangle":
        wave = 2.0 / np.pi * np.arcsin(wave)
    kappa = 0.01 * wave
    force = np.zeros_like(x)
    for i in range(1, x.size):
        decay = np.exp(-2e-3 / sigma)
        mean = 0.5 * (kappa[i] + kappa[i - 1])
        force[i] = decay * force[i - 1] + (1.0 - decay) * stiffness * mean
    found = frequency_response(x, kappa, force, skip=3.0)
    assert found.frequency[0] == pytest.approx(1.0 / wavelength, rel=2e-3)
    assert len(found.frequency) == {"sine": 1, "triangle": 2}[shape]
    exact = stiffness / (1.0 + 2j * np.pi * found.frequency * sigma)
    assert found.gain[0] == pytest.approx(abs(exact[0]), rel=0.01)
    assert found.phase_deg[0] == pytest.approx(np.degrees(np.angle(exact[0])), abs=0.5)
    assert found.first_order() == pytest.approx((sigma, stiffness), rel=0.03)
