# SPDX-License-Identifier: Apache-2.0
"""The base of the search against closed forms, its own halved step, and counting encoders."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from types import SimpleNamespace

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch import data as tiredata
from flatplank_analysis.contact_patch import grid, kernel
from flatplank_analysis.contact_patch.laws import patch_length
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.effects.force_law import DriveBrakeStiffness
from flatplank_data.run_record import RunRecord
from flatplank_validation.blind.nulls import nothing_hidden

STIFF, CARCASS, HALF, LOAD = 9.0e4, 2.3e5, 0.07, 3700.0


def _params(**changes):
    p = np.zeros((2, 1, kernel.WIDTH))
    values = {
        "stiff": STIFF, "peak": 1.05, "shape": 3.0, "carcass": CARCASS, "half": HALF,
        "tread": 1.0, "patch_order": 0.02, "play_soft": 10.0, "creep_time": 10.0,
    } | changes  # fmt: skip
    for name, value in values.items():
        p[..., kernel.NAMES.index(name)] = value
    return p


def _forces(ds, dw, **changes):
    """Fx and Fy (2, n) of one element; ds: step [m] of the plank, dw (2, 1, n)."""
    one, force = np.ones((1, dw.shape[-1])), np.zeros(dw.shape)
    kernel.sweep(
        kernel.blocks_of(np.arange(1)), True, True, ds * one, dw, ds / 0.03 * one, one * LOAD, one,
        _params(**changes), np.array([LOAD]), 0.03, force, None,
    )  # fmt: skip
    return force[:, 0]


def _run(kappa, step=0.0015, length=2.5, **changes):
    n = int(length / step)
    dw = np.zeros((2, 1, n))
    dw[0] = kappa * step
    return step * np.arange(1, n + 1), _forces(step, dw, **changes)[0]


def test_small_slip_is_first_order_with_the_sum_of_both_lengths():
    s, fx = _run(1e-5)
    sigma = STIFF / CARCASS + HALF
    expected = STIFF * 1e-5 * (1.0 - np.exp(-s / sigma))
    np.testing.assert_allclose(fx, expected, atol=0.02 * STIFF * 1e-5)


@pytest.mark.parametrize("kappa", [-0.1, -0.03, 0.01, 0.05])
def test_steady_force_is_the_law(kappa):
    _, fx = _run(kappa, length=6.0, denom=1.0)
    slip = kappa / (1.0 + kappa)
    law, _ = kernel.steady(slip, STIFF, 1.05 * LOAD, 3.0, 0.0, 0.0)
    assert fx[-1] == pytest.approx(law, rel=2e-3)


@pytest.mark.parametrize("slip", [0.01, 0.05, 0.1])
def test_driving_is_the_mirror_of_braking_over_the_travel_of_the_wheel(slip):
    """With ns = 1, as in a row of bristles: only the slip per travel of the wheel counts. A patch
    length that differed by the slip looked like another stiffness when braking."""
    rolled, dw = 0.003, np.zeros((2, 1, 400))
    dw[0] = slip * rolled
    for changes in ({}, {"patch_order": 1.0, "play": 3e-4}):
        drive = _forces(rolled * (1.0 - slip), dw, denom=1.0, **changes)[0]
        brake = _forces(rolled * (1.0 + slip), -dw, denom=1.0, **changes)[0]
        assert drive.max() > 500.0
        np.testing.assert_allclose(brake, -drive, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("kappa", [-0.1, -0.05, 0.01, 0.05, 0.1])
def test_the_length_of_the_patch_does_not_depend_on_how_the_travel_is_counted(kappa):
    """(7.17) and (7.18) hold over the travel of the plank. Over `ds + ns dw` the same length is
    longer or shorter, as that travel is."""

    def length(ns: float, theta: float) -> float:
        contact = kappa / (1.0 + ns * kappa)
        return patch_length(contact, abs(contact), theta, HALF, 1.0 - ns) / (1.0 + ns * kappa)

    for theta in (0.0, 4.0, 20.0):
        for ns in (0.3, 1.0):
            assert length(ns, theta) == pytest.approx(length(0.0, theta), rel=1e-12)
    # all of the patch adheres
    assert length(0.0, 0.0) == pytest.approx(HALF / (1.0 + kappa), rel=0.01)


@pytest.mark.parametrize("seed", [pytest.param(2, marks=pytest.mark.long), 3])
def test_grip_that_scatters_is_no_other_stiffness_when_braking(seed):
    """A tire whose grip scatters by 2 % from run to run, nothing hidden. The force then hardly
    limits the base's slip, and with ns beyond 1 it had 5 to 6 % less stiffness when braking."""
    tables = nothing_hidden("second", seed, 7.5, 0.02)
    state = Session.of_tables(tables).fit(None).state
    start = Term(DriveBrakeStiffness, DriveBrakeStiffness.vector({"less": 0.01}))
    found = state.with_term(start, most=12)
    assert abs(found.fit.terms[-1].size) < 0.03
    assert state.whitened.chi2 - found.chi2 < 20.0


def test_to_the_left_is_the_mirror_of_to_the_right():
    dw = np.zeros((2, 1, 400))
    dw[1] = 0.09 * 0.003
    left, right = _forces(0.003, dw)[1], _forces(0.003, -dw)[1]
    assert left.max() > 500.0
    np.testing.assert_allclose(right, -left, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("step", [0.0015, 0.0045])
def test_a_law_that_falls_does_not_let_the_slip_jump(step):
    """Beyond the peak the carcass took more slip back than the sliding patch follows: the force
    jumped by 100 N from node to node, and its derivatives were a thousand times too large."""
    s = step * np.arange(1, int(2.5 / step) + 1)
    kappa = -0.1 * (1.0 + 0.1 * np.sin(2.0 * np.pi * s / 0.1))

    def force(peak: float) -> np.ndarray:
        _, fx = _run(
            kappa, step, stiff=1.0356e5, peak=peak, shape=3.128, fall=0.0977, round=-0.0224,
            denom=0.92, carcass=2.226e5, half=0.0528, tread=1.222, patch_order=0.248,
        )  # fmt: skip
        return fx[s > 1.0]

    fx = force(1.0539)
    assert np.abs(np.diff(fx, 2)).max() < 3.0
    more = (force(1.0539 + 2e-5) - fx) / 2e-5
    assert np.abs(more - fx / 1.0539).max() < 0.1 * np.abs(fx / 1.0539).max()


def test_slope_of_the_law_is_its_derivative():
    for k in (-0.08, -0.02, 0.004, 0.03, 0.2):
        args = (STIFF, 1.05 * LOAD, 2.7, 0.05, 0.2)
        h = 1e-7
        up, down = kernel.steady(k + h, *args)[0], kernel.steady(k - h, *args)[0]
        assert kernel.steady(k, *args)[1] == pytest.approx((up - down) / (2 * h), rel=1e-4)


def test_halving_the_step_changes_little():
    coarse = _run(0.05, step=0.006, patch_order=0.8)
    fine = _run(0.05, step=0.003, patch_order=0.8)
    miss = coarse[1] - np.interp(coarse[0], *fine)
    assert np.abs(miss[5:]).max() < 12.0
    assert np.sqrt(np.mean(miss**2)) < 3.0


def test_play_holds_the_force_at_zero_for_the_gap():
    n = 600
    dw = np.zeros((2, 1, n))
    dw[0, 0] = np.where(np.arange(n) < 100, -3e-6, 6e-6)
    fx = _forces(0.0015, dw, play=6e-4, play_rest=-1.0, play_soft=2.0)[0]
    flat = np.sum(np.abs(fx[100:]) < 3.0) * 6e-6
    assert fx[99] < -20.0 and fx[-1] > 50.0
    assert flat == pytest.approx(6e-4, rel=0.2)


def test_counting_encoder_is_seen_and_smoothed():
    t = np.arange(0.0, 60.0, 0.05)
    true = 0.0999 * np.maximum(t - 1.0, 0.0)
    step = 2.0 * np.pi / 20000
    counted = np.float32(np.floor(true / step) * step).astype(float)
    found = grid.quantum(counted)
    assert found == pytest.approx(step, rel=0.08)
    smooth = grid.unquantise(counted, found, 20.0)
    inner = slice(200, -50)
    error = smooth - true
    error -= np.median(error[inner])
    assert np.std(error[inner]) < 0.3 * np.std((counted - true)[inner])
    assert grid.quantum(true + 1e-4 * np.random.default_rng(0).standard_normal(len(t))) == 0.0


@pytest.mark.parametrize("length", [3.0, 4.2])
def test_a_fine_step_of_an_even_motion_is_seen(length):
    """The changes are 98 or 99 counts but for five while it starts; single precision does not
    tell 98 from 99 over four metres, and they seemed to be multiples of 16 or 22 counts."""
    step = 2.0 * np.pi * 0.05 / 20000
    changes = np.array([0, 16, 49, 82, 98] + [98, 99, 98] * int(length / (295 * step)))
    counted = step * np.cumsum(changes)
    assert grid.quantum(counted) == pytest.approx(step, rel=0.15)
    assert grid.quantum(np.float32(counted).astype(float)) < 1.5 * step


@pytest.mark.parametrize("slip", [-0.1, -0.02, 0.05])
def test_counts_beside_a_step_of_the_slip_are_smoothed(slip):
    """They were kept for a second on either side: from node to node the force of the model moved
    by newtons, which a force that comes late seemed to explain."""
    t, step = np.arange(0.0, 100.0, 0.05), 2.0 * np.pi / 20000
    near = np.abs(t - 50.0) < 1.0
    kept, left = [], []
    for phase in np.linspace(0.0, 0.9, 10):
        true = 0.0964634 * (t + np.maximum(t - 50.0, 0.0) * slip) + phase * step
        counted = np.floor(true / step) * step
        smooth = grid.unquantise(counted, step, 20.0)
        error = grid.gaussian(np.stack([counted, smooth], axis=1) - true[:, None], 1.5)[near]
        rough = np.sqrt(np.mean(np.diff(error[::3], 2, axis=0) ** 2, axis=0))
        kept.append(rough[0])
        left.append(rough[1])
    assert np.mean(left) < 0.5 * np.mean(kept)


def test_a_curve_through_counts_stays_within_a_step_of_them():
    """A kink, and waves of three steps that come and go in 2.5 s."""
    t, step = np.arange(0.0, 100.0, 0.05), 2.0 * np.pi / 20000
    true = 0.0964634 * (t + 0.1 * np.maximum(t - 50.0, 0.0))
    true += 3.0 * step * np.sin(2.5 * t) * (t > 70.0)
    counted = np.floor(true / step) * step
    smooth = grid.unquantise(counted, step, 20.0)
    assert np.abs(smooth - counted).max() < step
    assert np.std((smooth - true)[t < 40.0]) < 0.1 * np.std((counted - true)[t < 40.0])


def test_filter_keeps_ramps():
    ramp = np.linspace(0.0, 3.0, 200)[:, None]
    np.testing.assert_allclose(grid.gaussian(ramp, 1.5), ramp, atol=1e-12)


def test_a_recording_that_begins_with_the_motion_gets_a_standstill():
    truth = Truth(seed=3, slips=(-0.05, 0.05), repeats=1, noise=0.0, lag=0.06)
    whole = campaign(truth)
    tables = []
    for table in whole:
        first = int(np.argmax(table["plank_position"] > 0.0)) - 1
        columns = {name: table[name][first:] for name in table.columns}
        tables.append(type(table)(columns, table.info))
    assert (whole[0]["time"][0], tables[0]["time"][0]) == (0.0, pytest.approx(0.5, abs=0.1))
    expected, found = tiredata.from_tables(whole), tiredata.from_tables(tables)
    np.testing.assert_allclose(found.travel, expected.travel, atol=1e-6)
    np.testing.assert_allclose(found.step_time, expected.step_time, atol=1e-4)
    np.testing.assert_allclose(found.runs.measured, expected.runs.measured, atol=0.5)


def _named_conditions(*changes):
    usual = RunRecord(
        measurement="slip", fz=3700.0, pressure=2.5, kappa=0.05, step_position=1.5, speed=0.03
    )
    return tiredata._conditions([SimpleNamespace(info=replace(usual, **c)) for c in changes])


def test_conditions_are_named_by_what_differs():
    label = "κ +5 %, Fz 3700 N, 2.5 bar"
    assert _named_conditions({}, {})[1] == (label,)
    groups, names = _named_conditions({}, {"step_position": 0.9}, {}, {"kappa": -0.05})
    assert names == (label.replace("+", "-"), f"{label}, step at 0.9 m", f"{label}, step at 1.5 m")
    assert groups.tolist() == [2, 1, 2, 0]


def test_no_two_conditions_have_the_same_name():
    changes = (
        {}, {"step_position": nan}, {"direction": -1.0}, {"waveform": {"name": "sine"}},
        {"waveform": {"name": "sine", "amplitude": 0.02}}, {"speed": nan}, {"tire": "another"},
    )  # fmt: skip
    groups, names = _named_conditions(*changes)
    assert sorted(groups) == [*range(len(changes))] and len({*names}) == len(changes)
    assert not any(word in " ".join(names) for word in ("None", "nan", "{"))


def test_base_fits_bristles_to_half_the_floor():
    from flatplank_analysis.contact_patch.model import TireModel
    from flatplank_analysis.discovery.fit import Fitter
    from flatplank_analysis.discovery.state import channel_weights, start_base

    truth = Truth(seed=11, slips=(-0.05, -0.02, 0.0, 0.02, 0.05), repeats=2)
    model = TireModel(tiredata.from_tables(campaign(truth)))
    fit = Fitter(model, channel_weights(model, [10.0, 5.0, 7.0])).fit(start_base(model))
    runs = model.runs
    residual = fit.residual(runs.measured)[0]
    floor2 = np.sum(runs.contrast(residual) ** 2) / (5 * runs.samples)
    beyond2 = np.mean(runs.mean(residual) ** 2) - floor2 / 2.0
    assert beyond2 < 0.25 * floor2
