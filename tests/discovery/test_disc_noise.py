# SPDX-License-Identifier: Apache-2.0
"""The noise of a campaign against covariances that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import CONDITIONS, NOISE, REPEATS, TIME, Sum, measured

from flatplank_analysis.discovery import noise as noises
from flatplank_analysis.discovery.fit import Fitter
from flatplank_analysis.discovery.model import FormError
from flatplank_analysis.discovery.noise import ChannelNoise, fit_noise, freedom_of, make_whitener
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.state import make_state, start_base
from flatplank_analysis.inference.search import run_search

LONG = 135.0
TRUE = np.array([1.0, 0.0, 0.0, 2.0, 0.0, 3.0, 0.0, 0.0, 0.0])
"""white, filtered white, 0.5, 1.5, 5, 15, 50 s, level, drift"""


def lasting(seconds: float, samples: int, channels: int = 1) -> RunSet:
    """Empty runs of that length."""
    runs = measured(0).runs
    time = np.broadcast_to(np.linspace(0.0, seconds, samples), (runs.runs, samples)).copy()
    zero = np.zeros((channels, runs.runs, samples))
    names = tuple("xyz"[:channels])
    return replace(runs, time=time, measured=zero, channels=names, coordinates={})


def drawn(runs: RunSet, weights: np.ndarray, seed: int) -> np.ndarray:
    """Noise (runs, samples) with these variances of its components."""
    t = runs.time[0]
    covariance = np.tensordot(weights, noises._components(t), axes=1)
    root = np.linalg.cholesky(covariance + 1e-9 * np.eye(len(t)))
    return np.random.default_rng(seed).standard_normal(runs.measured.shape[1:]) @ root.T


@pytest.mark.parametrize("stretch", [1.0, 2.0])
def test_correlations_of_the_components(stretch):
    """Their times are those of a run of 135 s."""
    tau = np.array([0.0, 0.15, 1.5, 60.0])
    found = noises._kernel(stretch * tau, stretch * LONG)
    wanted = [tau == 0.0, np.exp(-((tau / 0.15) ** 2))]
    wanted += [np.exp(-tau / t) for t in (0.5, 1.5, 5.0, 15.0, 50.0)]
    np.testing.assert_allclose(found, np.array([*wanted, np.ones(4)]))
    drift = noises._components(stretch * np.linspace(7.0, 7.0 + LONG, 3))[-1]
    np.testing.assert_allclose(drift, 3.0 * np.outer([-1, 0, 1], [-1, 0, 1]), atol=1e-9)


def test_noise_of_repeats_is_found():
    """What the repeats share is none; the mean of three takes a third of it."""
    runs = lasting(LONG, 330)
    shared = 40.0 * np.sin(np.arange(330) / 20.0)
    found = []
    for seed in range(8):
        residual = shared + drawn(runs, TRUE, seed)
        contrast = runs.contrast(residual)[None]
        (noise,) = fit_noise(runs, contrast, 0.0 * contrast, _none(runs))
        found.append(noise)
    weights = np.mean([n.weights for n in found], axis=0)
    tau = np.array([0.0, 2.0, 5.0, 12.0, 40.0])
    of = [w[:-1] @ noises._kernel(tau, LONG) for w in (weights, TRUE)]
    np.testing.assert_allclose(of[0], of[1], atol=0.7)
    assert weights.sum() == pytest.approx(6.0 * 1.02, rel=0.05)
    assert 0.9 < np.mean([n.scale.mean() for n in found]) < 1.1
    np.testing.assert_allclose(np.ptp(found[0].scale.reshape(CONDITIONS, REPEATS), axis=1), 0.0)


def test_levels_that_differ_from_run_to_run_are_found():
    """Five sixths of the variance; as slow as a level is nothing else but fifty seconds."""
    runs, found = lasting(LONG, 120), []
    for seed in range(6):
        contrast = runs.contrast(drawn(runs, np.eye(9)[0] + 5.0 * np.eye(9)[7], seed))[None]
        (noise,) = fit_noise(runs, contrast, 0.0 * contrast, _none(runs))
        found.append(noise.weights)
    mean = np.mean(found, axis=0)
    assert mean[7] > 3.0 and mean[6:8].sum() == pytest.approx(5.0, rel=0.25)


def test_noise_that_is_too_quiet_gets_larger_slow_components():
    """In equal parts, until the whole has the level; the noise of the sensor is known."""
    noise = ChannelNoise(TRUE, np.array([0.5, 1.0, 1.0, 1.0, 3.0]))
    louder = noises.no_quieter(noise, 4.0)
    assert louder.weights.sum() == pytest.approx(16.0)
    np.testing.assert_allclose(louder.weights[:2], TRUE[:2])
    np.testing.assert_allclose(louder.weights[2:] - TRUE[2:], 10.0 / 7.0)
    assert noise.weights is TRUE and TRUE.sum() == 6.0 and louder.scale is noise.scale
    # its own level is 6 ** 0.5
    assert noises.no_quieter(noise, 2.4) is noise and noises.no_quieter(noise, 2.5) is not noise
    twice = replace(noise, scale=2.0 * noise.scale)
    assert noises.no_quieter(twice, 4.8) is twice
    assert 4.0 * noises.no_quieter(twice, 5.0).weights.sum() == pytest.approx(25.0)


def test_a_drift_that_differs_from_run_to_run_is_noise_of_its_own():
    """A random walk and a level, as far as they imitate it, leave it six times too large."""
    runs = lasting(LONG, 330)
    ramp = np.broadcast_to(np.linspace(-1.0, 1.0, 330), (1, runs.runs, 330))
    squares = []
    for seed in range(4):
        random = np.random.default_rng(seed)
        residual = 3.0 * random.standard_normal((runs.runs, 1)) * ramp[0]
        residual = residual + 0.5 * random.standard_normal(residual.shape)
        contrast = runs.contrast(residual)[None]
        made = make_whitener(runs, fit_noise(runs, contrast, 0.0 * contrast, _none(runs)))
        column, noise = made.apply(ramp, 0)[0], made.apply(residual[None], 0)[0]
        squares.append(np.sum(column * noise, axis=1) ** 2 / np.sum(column**2, axis=1))
    assert 0.6 < np.mean(squares) < 1.6


def test_noise_does_not_depend_on_when_a_clock_was_set():
    runs = lasting(LONG, 330)
    residual = drawn(runs, TRUE, 5)
    contrast = runs.contrast(residual)[None]
    one, other = (
        fit_noise(r, contrast, residual[None], _none(r))[0]
        for r in (runs, replace(runs, time=runs.time + 1000.0))
    )
    np.testing.assert_allclose(one.weights, other.weights, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(one.scale, other.scale, rtol=1e-6)


def _none(runs: RunSet) -> np.ndarray:
    return np.zeros((0, len(runs.channels), runs.runs, runs.samples))


@pytest.mark.parametrize(("samples", "used"), [(120, 120), (900, 225)])
def test_independent_numbers_in_a_run(samples, used):
    runs = lasting(LONG, samples)
    for component, wanted in ((0, used), (7, 1.0), (8, 1.0)):
        noise = ChannelNoise(3.0 * np.eye(9)[component], np.ones(runs.runs))
        assert freedom_of(runs, noise) == pytest.approx(wanted)


def test_whitened_noise_is_independent_and_of_unit_size():
    """By channel and time base; the scale of a run and its roughness are taken out."""
    runs = lasting(LONG, 900, channels=2)
    time = runs.time.copy()
    time[12:] *= 1.3
    time[3] += 0.01 * LONG
    rough = np.full(time.shape, 2.0)
    rough[5] = 4.0
    runs = replace(runs, time=time, roughness=rough)
    scale = np.linspace(0.5, 2.0, runs.runs)
    kinds = [ChannelNoise(w, scale) for w in (TRUE, 2.0 * np.eye(9)[0])]
    made = make_whitener(runs, kinds)
    assert list(made.picks) == list(range(0, 900, 3))
    assert list(made.base_of) == [0] * 5 + [1] + [0] * 6 + [2] * 12
    for base, run in ((0, 0), (2, 20)):
        t = time[made.base_of == base][:, made.picks].mean(axis=0)
        covariance = np.tensordot(TRUE, noises._components(t), axes=1)
        root = np.linalg.cholesky(covariance)
        values = np.zeros((300, runs.runs, 900))
        values[:, run, made.picks] = root.T * scale[run] * 2.0
        white = made.apply(values, 0)[:, run]
        np.testing.assert_allclose(white.T @ white, np.eye(300), atol=1e-4)
    white = made.apply(np.ones((1, runs.runs, 900)), 1)[0]
    np.testing.assert_allclose(white, (1.0 / (2.0**0.5 * scale * rough[:, 0]))[:, None]
                               * np.ones(300), rtol=1e-5)  # fmt: skip


def test_runs_of_nearly_the_same_times_share_a_whitening():
    """Within two hundredths of the length of the first one, everywhere along the run."""
    runs = lasting(LONG, 60)
    time = runs.time.copy()
    time[1] += 0.019 * LONG
    time[2] += 0.021 * LONG
    time[3] -= 0.021 * LONG
    time[4, 30] += 0.021 * LONG
    time[5] = time[2] + 0.019 * LONG
    noise = ChannelNoise(np.eye(9)[0], np.ones(runs.runs))
    made = make_whitener(replace(runs, time=time), [noise])
    assert made.base_of[:7].tolist() == [0, 0, 1, 2, 3, 1, 0]
    assert sorted(made.factors) == [(0, base) for base in range(4)]


def test_the_level_of_a_run_is_no_better_known_where_the_model_is_rough():
    """The level was multiplied by the roughness, too: an offset over the whole run, smaller there,
    then looked like no level, and had thirty times the information that the level permits."""
    runs = lasting(LONG, 300)
    rough = np.ones_like(runs.time)
    rough[:, :60] = 2.5
    noise = ChannelNoise(np.array([1.0, 0, 0, 0, 0, 0, 0, 100.0, 0]), np.ones(runs.runs))
    made = make_whitener(replace(runs, roughness=rough), [noise])
    offset = made.apply(np.ones((1, runs.runs, 300)), 0)[0, 0]
    # alone, the level of variance 100 permits 1/100 at most
    smooth = make_whitener(runs, [noise]).apply(np.ones((1, runs.runs, 300)), 0)[0, 0]
    assert 0.0095 < offset @ offset <= smooth @ smooth < 0.01


def test_a_rough_place_has_the_noise_and_an_error_of_its_own():
    """Within it the noise is larger by the factor; with the rest it correlates as before."""
    runs = lasting(LONG, 100)
    rough = np.ones_like(runs.time)
    rough[:, :30] = 3.0
    made = make_whitener(replace(runs, roughness=rough), [ChannelNoise(TRUE, np.ones(runs.runs))])
    t = runs.time[0]
    plain = np.tensordot(TRUE, noises._components(t), axes=1)
    wanted = plain.copy()
    wanted[:30, :30] *= 9.0
    root = np.linalg.inv(made.factors[0, 0])
    np.testing.assert_allclose(root @ root.T, wanted, atol=1e-3)


class Turned(Sum):
    """Its slope scatters from run to run."""

    def scatter_directions(self, base):
        return ({"slope": 1.0},)


def test_the_standard_error_of_a_place_has_the_noise_and_the_scatter_there():
    """One condition's repeats are alike by chance: the others say how much they scatter."""
    random = np.random.default_rng(5)
    slopes = 0.2 * random.standard_normal(CONDITIONS * REPEATS)
    slopes[:REPEATS] = 0.0
    model = Turned(measured(3, (slopes, lambda c: TIME)).runs)
    state = run_search(model, []).last.state
    error = state.expected_errors
    assert error.shape == (CONDITIONS, len(TIME))
    noise, scatter = NOISE / np.sqrt(REPEATS), 0.2 * np.abs(TIME) / np.sqrt(REPEATS)
    np.testing.assert_allclose(error[:, 0], noise, rtol=0.3)
    np.testing.assert_allclose(error[:, -1], scatter[-1], rtol=0.4)
    once = Turned(model.runs.subset(np.arange(0, CONDITIONS * REPEATS, REPEATS)))
    assert not replace(state, model=once).expected_errors.any()


class Pair(Sum):
    """Two channels of one law."""

    def predict(self, sets):
        return np.repeat(super().predict(sets)[:, :1], 2, axis=1)


def test_the_error_of_the_form_is_no_evidence():
    """A tenth of the largest mean signal, which is 1.4: 0.14 beside a noise of 0.05. The floor of
    the first channel is that of the noise alone: what is left beyond it is told."""
    runs = measured(37).runs
    both = np.concatenate([runs.measured, measured(38).runs.measured])
    model = Pair(replace(runs, channels=("x", "y"), measured=both))
    fitter = Fitter(model, np.ones((2, 1, 1)))
    fit = fitter.fit(start_base(model))
    before = make_state(model, fitter, fit, [])
    plain = before.metric.whitener.noises
    model.form = FormError(mean=0.2, side=0.1)
    state = make_state(model, fitter, fit, [])
    first, second = state.metric.whitener.noises
    assert plain[1].weights.sum() == pytest.approx(NOISE**2, rel=0.2)
    assert first.weights.sum() == pytest.approx(0.28**2, rel=0.05)
    assert second.weights.sum() == pytest.approx(0.14**2, rel=0.05)
    np.testing.assert_allclose(state.noise.weights, plain[0].weights)
    assert str(state.floors[0]) == str(before.floors[0])
    assert state.floors[1].freedom < before.floors[1].freedom
    np.testing.assert_allclose(state.expected_errors, before.expected_errors)
    np.testing.assert_allclose(state.metric.scatter, before.metric.scatter)


def test_where_nothing_is_repeated_the_residual_is_the_noise_and_rest_is_the_floor():
    runs = measured(39).runs.subset(np.arange(0, CONDITIONS * REPEATS, REPEATS))
    for known, floor in (({"rest": (0.03,)}, 0.03), ({"rest": (0.07,)}, 0.07)):
        model = Sum(replace(runs, **known))
        fitter = Fitter(model, np.ones((1, 1, 1)))
        state = make_state(model, fitter, fitter.fit(start_base(model)), [])
        assert state.floors[0].floor == pytest.approx(floor)
        (noise,) = state.metric.whitener.noises
        assert noise.weights.sum() == pytest.approx(NOISE**2, rel=0.2)
        beyond = max(state.runs.rmse(state.residual[0]) ** 2 - floor**2, 0.0)
        assert state.floors[0].unexplained == pytest.approx(np.sqrt(beyond))
