# SPDX-License-Identifier: Apache-2.0
"""The third tire of the blind kit: closed forms, its own halved step, and what it hides."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_analysis.effects.registry import library
from flatplank_sim.sealed.conditions import Run, Setting
from flatplank_validation.blind import third_kernel as kernel
from flatplank_validation.blind.third import DESIGNS, SAMPLES, ThirdMachine, ThirdTire, measure
from flatplank_validation.blind.third_world import HIDES, ThirdWorld
from flatplank_validation.blind.worlds import Scatter

CALM = np.zeros(4)


def rolled(kappa, alpha_deg, load=3700.0, h=0.025, seconds=100.0, **changes):
    """Forces [N] while the tire rolls at a slip, (steps, 2)."""
    tire = ThirdTire(**changes).numbers(load, 1.0, 0.0)
    state, feet, press = np.zeros(7), np.zeros((kernel.MOST, 3)), np.zeros(kernel.MOST)
    alpha, newest, out = math.radians(alpha_deg), 0, []
    for _ in range(int(seconds / h)):
        way = 0.03 * h
        x, y = way * math.cos(alpha), -way * math.sin(alpha)
        turned = x * (1.0 + kappa)
        newest = kernel.step(
            state, feet, press, newest, tire, load, 1.0, turned, turned - x, y, h
        )  # fmt: skip
        out.append(state[5:7].copy())
    return np.array(out)


def half_length(load=3700.0):
    return kernel.contact_of(load, ThirdTire().numbers(load, 1.0, 0.0))


def test_small_slip_bends_the_threads_over_the_contact():
    half, _, _ = half_length()
    t = ThirdTire()
    fx, fy = rolled(1e-3, 0.05)[-1]
    assert fx == pytest.approx(2.0 * t.thread_x * half**2 * 1e-3, rel=0.03)
    assert fy == pytest.approx(
        -2.0 * t.thread_y * half**2 * math.tan(math.radians(0.05)), rel=0.03
    )


def test_the_first_travel_bends_carcass_and_threads_in_series():
    t, (half, _, _) = ThirdTire(), half_length()
    tire = t.numbers(3700.0, 1.0, 0.0)
    state, feet, press = np.zeros(7), np.zeros((kernel.MOST, 3)), np.zeros(kernel.MOST)
    for _ in range(400):
        kernel.step(state, feet, press, 0, tire, 3700.0, 1.0, 0.0, 1e-7, 0.0, 0.025)
    threads = 2.0 * half * t.thread_x
    series = threads * t.carcass_x / (threads + t.carcass_x)
    assert state[5] == pytest.approx(4e-5 * series, rel=0.02)


def test_deep_slip_slides_along_the_slip_within_the_grip():
    _, gx, gy = half_length()
    for kappa, alpha in ((1.0, 0.0), (0.0, 45.0), (-0.5, 30.0)):
        fx, fy = rolled(kappa, alpha, seconds=40.0, lost=0.0)[-1]
        assert math.hypot(fx / gx, fy / gy) == pytest.approx(3700.0, rel=0.02)
        assert fx * kappa >= 0.0 and fy <= 0.0
    alike = {"grip_x": 1.0, "grip_y": 1.0, "thread_x": 9e6, "thread_y": 9e6}
    fx, fy = rolled(-0.5, 30.0, seconds=40.0, lost=0.0, **alike)[-1]
    assert fy / fx == pytest.approx(math.tan(math.radians(30.0)) / 0.5, rel=0.02)


@pytest.mark.parametrize(("kappa", "alpha"), [(0.1, 0.0), (-0.1, 5.0), (0.02, 5.0)])
def test_halving_the_step_changes_little(kappa, alpha):
    coarse, fine = rolled(kappa, alpha), rolled(kappa, alpha, h=0.0125)[1::2]
    assert np.abs(coarse - fine).max() < 8.0
    assert np.abs(np.diff(coarse[2000:], axis=0)).max() < 4.0


def test_the_grip_falls_with_the_load_and_the_contact_grows():
    (small, few, _), (large, many, _) = half_length(1850.0), half_length(5550.0)
    assert small < large and few > many
    assert 1.2 < large / small < math.sqrt(3.0)


def one(machine=None, **setting):
    run = Run(Setting(**{"kappa": 0.0} | setting), 1, 0)
    return measure(ThirdTire(), machine or ThirdMachine(), run, 1.0, 0.09, CALM)


def test_signs_are_iso_and_the_step_is_where_it_ought_to_be():
    for kappa in (-0.05, 0.05):
        c = one(kappa=kappa, alpha_deg=5.0)
        late = c["plank_position"] > 3.0
        assert np.mean(c["fx"][late]) * kappa > 0.0 and np.mean(c["fy"][late]) < 0.0
        gone = c["plank_position"][late][[0, -1]]
        slip = np.diff(c["wheel_angle"][late][[0, -1]]) * ThirdWorld().radius
        slip = slip / (np.diff(gone) * math.cos(math.radians(5.0))) - 1.0
        assert slip[0] == pytest.approx(kappa, abs=1e-3)
    assert one()["fz"].mean() == pytest.approx(3700.0)


def test_road_play_is_so_much_lost_travel():
    # the wheel starts late, so the plate rests at its braking end: driving, it crosses the gap
    plain, play = one(kappa=0.02), one(ThirdMachine(road_play=1e-3), kappa=0.02)
    x = np.arange(1.5, 2.6, 1e-4)
    a, b = (np.interp(x, c["plank_position"], c["fx"]) for c in (plain, play))
    for level in (400.0, 700.0):
        shift = (np.argmax(b > level) - np.argmax(a > level)) * 1e-4 * 0.02
        assert shift == pytest.approx(1e-3, rel=0.15)


def test_steering_play_turns_the_wheel_by_half_of_it():
    free = math.radians(0.3)
    steered = one(ThirdMachine(steering_play=free), alpha_deg=3.0)["fy"][-1]
    assert steered == pytest.approx(one(alpha_deg=3.0 - 0.3)["fy"][-1], rel=3e-3)


def test_load_loss_parasitic_patch_and_carcass():
    lost = one(ThirdMachine(loss=0.05), kappa=-0.1)
    assert 3700.0 - lost["fz"][-1] == pytest.approx(-0.05 * (lost["fx"][-1] + 29.0), rel=0.03)
    turning = one(ThirdMachine(parasitic=(40.0, 28.0)))["fx"] - one()["fx"]
    assert np.ptp(turning) == pytest.approx(80.0, rel=0.02)
    a, b = one(kappa=0.1), one(ThirdMachine(patch=(2.5, 2.9, 0.1)), kappa=0.1)
    at = np.argmin(np.abs(a["plank_position"] - 2.8))
    # not all of the contact slides
    assert 0.9 < b["fx"][at] / a["fx"][at] < 0.93
    a, b = one(kappa=0.02, fz=5550.0), one(ThirdMachine(carcass_load=1.0), kappa=0.02, fz=5550.0)
    near = np.abs(a["plank_position"] - 1.6) < 0.05
    assert np.mean(b["fx"][near]) > 1.05 * np.mean(a["fx"][near])


def test_the_world_makes_the_same_campaign_again_and_hides_what_the_library_knows():
    assert set(HIDES) <= set(library())
    runs = [Run(s, 1, i) for i, s in enumerate(DESIGNS["combined"][:3])]
    again = []
    for _ in range(2):
        random = np.random.default_rng(4)
        world = ThirdWorld.drawn(random)
        scatter = Scatter.drawn(len(runs), 0.02, random)
        again.append(world.run(runs, {"worn_patch": 0.1}, random, scatter))
    for a, b in zip(*again, strict=True):
        np.testing.assert_array_equal(a["fx"], b["fx"])
        assert len(a["time"]) < SAMPLES
