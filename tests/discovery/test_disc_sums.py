# SPDX-License-Identifier: Apache-2.0
"""Sizes, scores and their dispersion, against the same numbers in plain linear algebra."""

from __future__ import annotations

import numpy as np
import pytest
from draws import RUNS, numbers, without
from scipy.special import digamma, polygamma

from flatplank_analysis.discovery import dispersion
from flatplank_analysis.discovery.gram import Gram, Metric, solve
from flatplank_analysis.discovery.noise import ChannelNoise, Whitener


def plain(samples: int) -> Whitener:
    """Noise that is white and of unit size."""
    unit = ChannelNoise(np.eye(8)[0], np.ones(RUNS))
    return Whitener(np.arange(samples), {(0, 0): np.eye(samples)}, np.zeros(RUNS, int), [unit])


def test_sizes_and_their_covariance_by_least_squares():
    columns, goal = numbers(1, 50, 3) * [1.0, 1e3, 1e-3], numbers(2, 50)
    sizes, covariance = solve(columns.T @ columns, columns.T @ goal)
    np.testing.assert_allclose(sizes, np.linalg.lstsq(columns, goal, rcond=None)[0], rtol=1e-6)
    np.testing.assert_allclose(covariance @ columns.T @ columns, np.eye(3), atol=1e-6)
    # a direction that is there twice has no information of its own
    twice = columns[:, [0, 0]]
    np.testing.assert_allclose(solve(twice.T @ twice, twice.T @ goal)[0].sum(),
                               columns[:, 0] @ goal / (columns[:, 0] @ columns[:, 0]))  # fmt: skip


def test_of_a_stiff_direction_as_much_is_taken_out_as_its_size_is_uncertain():
    """e' (1 + s^2 g g')^-1 e, the generalised least squares of a random size s in every run."""
    stiff, scatter = numbers(3, 3, 1, RUNS, 30), np.array([0.4, 0.9, 0.6])
    values = numbers(4, 2, 1, RUNS, 30)
    found = Metric(plain(30), stiff, scatter).gram(values[0], values)
    for r in range(RUNS):
        g = stiff[:, 0, r].T * scatter
        metric = np.linalg.inv(np.eye(30) + g @ g.T)
        e, x = values[0, 0, r], values[:, 0, r]
        assert found.energy[r] == pytest.approx(e @ metric @ e)
        np.testing.assert_allclose(found.scores[r], x @ metric @ e)
        np.testing.assert_allclose(found.products[r], x @ metric @ x.T, atol=1e-9)
    total = found.total([1, 3])
    np.testing.assert_allclose(total[0], found.products[1] + found.products[3])
    assert total[2] == pytest.approx(found.energy[1] + found.energy[3])
    # little scatter changes little, and none nothing
    for size in (0.0, 1e-6):
        still = Metric(plain(30), stiff, size * scatter)
        np.testing.assert_allclose(still(values), values[:, 0], atol=1e-5)


def test_priors_are_one_run_more():
    """Ridge regression: the first two columns have priors, the third has none."""
    columns, e = numbers(24, RUNS, 3, 20), numbers(25, RUNS, 20)
    gram = Gram.of(columns, e)
    more = gram.with_priors(np.array([4.0, 9.0]), np.array([0.5, -1.5]))
    assert more.energy.tolist() == [*gram.energy.tolist(), 0.0]
    np.testing.assert_array_equal(more.products[:-1], gram.products)
    products, scores, energy = more.total()
    np.testing.assert_allclose(products, gram.total()[0] + np.diag([4.0, 9.0, 0.0]))
    np.testing.assert_allclose(scores, gram.total()[1] + [0.5, -1.5, 0.0])
    assert energy == pytest.approx(np.sum(e**2))


def two_channels(samples: int) -> tuple[Whitener, np.ndarray]:
    """A whitener of two channels, and the noise of the second one (runs,): half in one run."""
    scale = np.where(np.arange(RUNS) == 2, 0.5, 1.0)
    unit = [ChannelNoise(np.eye(8)[0], s) for s in (np.ones(RUNS), scale)]
    factors = {(c, 0): (c + 1.0) * np.eye(samples) for c in range(2)}
    return Whitener(np.arange(samples), factors, np.zeros(RUNS, int), unit), scale


def test_channels_that_a_column_leaves_alone_stay_zero():
    """Of two channels, the second one with half of the noise in one run."""
    samples = 15
    whitener, scale = two_channels(samples)
    values = -np.abs(numbers(26, 3, 2, RUNS, samples))
    values[1, 0] = values[2] = 0.0
    white = Metric(whitener, values[:0], np.zeros(0))(values)
    assert white.shape == (3, RUNS, 2 * samples)
    wanted = np.concatenate([values[:, 0], 2.0 * values[:, 1] / scale[:, None]], axis=2)
    np.testing.assert_allclose(white, wanted)


def test_scores_of_an_amplitude_with_the_base_taken_out():
    base, x, e = numbers(7, RUNS, 2, 40), numbers(8, RUNS, 1, 40), numbers(9, RUNS, 40)
    gram = Gram.of(np.concatenate([base, x], axis=1), e)
    score, info = dispersion.scores_of(gram, 2)
    flat = np.moveaxis(base, 1, 0).reshape(2, -1).T
    away = [without(flat, v) for v in (x.ravel(), e.ravel())]
    own, left = (v.reshape(RUNS, 40) for v in away)
    size = np.sum(own * left) / np.sum(own**2)
    np.testing.assert_allclose(info, np.sum(own**2, axis=1))
    np.testing.assert_allclose(score, np.sum(own * (left - size * own), axis=1), atol=1e-9)


def test_dispersion_among_repeats():
    """Of groups that know as much: the variance of the scores; of others by what each knows."""
    groups = [np.array([0, 1, 2]), np.array([3, 4]), np.array([5])]
    score, info = numbers(10, 6), np.full(6, 2.0)
    kappa, freedom = dispersion.among_repeats(groups, score, info)
    spread = sum(np.sum((score[g] - score[g].mean()) ** 2) for g in groups)
    assert (kappa, freedom) == (pytest.approx(spread / (2.0 * 3.0)), pytest.approx(3.0))
    uneven = np.array([1.0, 2.0, 3.0, 8.0, 2.0, 1.0])
    assert dispersion.among_repeats(groups, 5.0 * uneven, uneven)[0] == pytest.approx(0.0)
    bottom = np.array([6.0 * 2.0 / 3.0, 10.0 / 2.0])
    wanted = bottom.sum() ** 2 / (bottom[0] ** 2 / 2.0 + bottom[1] ** 2)
    assert dispersion.among_repeats(groups, score, uneven)[1] == pytest.approx(wanted)
    assert dispersion.among_repeats(groups[2:], score, info) == (1.0, 1.0)


def test_moments_of_the_logs_of_dispersions():
    for x in (0.3, 2.0, 40.0):
        assert dispersion._trigamma_inverse(float(polygamma(1, x))) == pytest.approx(x)
    # no more spread than their own freedom makes: as sure as a campaign can be
    own, most = 6.0, dispersion.MOST_FREEDOM
    found = dispersion.typical_dispersion([2.5] * 8, [own] * 8)
    level = np.log(2.5) - digamma(own / 2) + np.log(own / 2)
    assert found.freedom == most
    wanted = np.exp(level + digamma(most / 2) - np.log(most / 2))
    assert found.dispersion == pytest.approx(wanted)
    # and with a spread of trigamma(3) beyond it, six
    logs = np.sqrt((polygamma(1, 3.0) + polygamma(1, own / 2)) * 0.875) * np.array([1, -1] * 4)
    found = dispersion.typical_dispersion(9.0 * np.exp(logs), [own] * 8)
    assert found.freedom == pytest.approx(6.0)
    assert found.dispersion == pytest.approx(9.0)
    assert dispersion.typical_dispersion([0.01] * 8, [own] * 8).dispersion == 1.0
    # those without scores are not asked
    assert (
        dispersion.typical_dispersion([3.0] * 4 + [0.0] * 9, [own] * 13)
        == dispersion.TypicalDispersion()
    )
    assert (
        dispersion.typical_dispersion([3.0] * 4 + [5.0] * 9, [own] * 4 + [0.5] * 9)
        == dispersion.TypicalDispersion()
    )
