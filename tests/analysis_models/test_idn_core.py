# SPDX-License-Identifier: Apache-2.0
"""Least squares against certified numbers, noise models, covariance from runs that scatter."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_analysis.identify.least_squares import solve
from flatplank_analysis.identify.linear import transient_end, transient_weights
from flatplank_analysis.identify.mf.information import Candidate, confusions
from flatplank_analysis.identify.noise import (
    ARNoise,
    fit_noise,
    repeat_differences,
    run_covariance,
)
from flatplank_analysis.identify.results import Estimate, Fit, relative_error, rmse, to_plain
from flatplank_analysis.post.gridding import bin_means
from flatplank_data.errors import FlatplankError
from flatplank_validation.fits.campaigns import coloured_noise

# NIST Statistical Reference Datasets, Misra1a (lower level of difficulty), certified values.
MISRA_Y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40,
           75.47, 81.78]  # fmt: skip
MISRA_X = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1,
           689.1, 760.0]  # fmt: skip


@pytest.mark.parametrize("start", [(500.0, 1e-4), (250.0, 5e-4)])
def test_nist_misra1a(start: tuple[float, float]) -> None:
    x, y = np.array(MISRA_X), np.array(MISRA_Y)

    def residuals(sets: np.ndarray) -> np.ndarray:
        return sets[:, :1] * -np.expm1(-sets[:, 1:] * x) - y

    found = solve(residuals, np.array(start), np.zeros(2), np.array([1e4, 1.0]))
    assert found.x == pytest.approx([2.3894212918e2, 5.5015643181e-4], rel=1e-6)
    assert found.cost == pytest.approx(1.2455138894e-1, rel=1e-8)
    variance = found.cost / (len(x) - 2) * np.linalg.inv(found.jacobian.T @ found.jacobian)
    assert np.sqrt(np.diag(variance)) == pytest.approx([2.7070075241, 7.2668688436e-6], rel=1e-4)


def test_search_stops_at_a_bound_and_says_so() -> None:
    found = solve(
        lambda sets: np.hstack([sets[:, :1] - 3.0, sets[:, 1:] + 1.0]),
        np.array([0.5, 0.5]),
        np.array([0.0, -5.0]),
        np.array([2.0, 5.0]),
    )
    assert found.x == pytest.approx([2.0, -1.0])
    assert list(found.at_upper) == [True, False]
    assert not found.at_lower.any()
    assert found.converged is True  # a plain value, for JSON


def test_search_leaves_a_parameter_without_influence_alone() -> None:
    found = solve(
        lambda sets: sets[:, :1] - np.array([1.0, 1.2]),
        np.array([0.0, 7.0]),
        np.full(2, -10.0),
        np.full(2, 10.0),
    )
    assert found.x == pytest.approx([1.1, 7.0])


def test_noise_model_is_found_again() -> None:
    rng = np.random.default_rng(5)
    series = list(coloured_noise(rng, (12, 1300), 10.0, (0.6, 0.3)))
    noise = fit_noise(series)
    assert noise.coefficients[:2] == pytest.approx((0.6, 0.3), abs=0.05)
    assert noise.std == pytest.approx(10.0, rel=0.1)


def test_noise_score_covariance_is_that_of_many_draws() -> None:
    rng = np.random.default_rng(6)
    noise = ARNoise((0.9,), 1.0, 1000)
    jac = np.column_stack([np.linspace(0, 1, 300), np.ones(300)])
    draws = coloured_noise(rng, (4000, 300), noise.std, (0.9,))
    np.testing.assert_allclose(noise.score_covariance(jac), np.cov((draws @ jac).T), rtol=0.1)


def test_noise_of_repeats_forgets_what_they_share() -> None:
    rng = np.random.default_rng(7)
    shared = 300.0 * np.sin(np.linspace(0, 9, 900))
    groups = [shared + rng.standard_normal((3, 900)) for _ in range(4)]
    noise = fit_noise(repeat_differences(groups))
    assert noise.std == pytest.approx(1.0, rel=0.05)
    assert fit_noise([np.zeros(100)]).std == 0.0


def test_covariance_of_scattering_runs_covers() -> None:
    rng = np.random.default_rng(8)
    runs, each, hits = 24, 40, 0
    index = np.repeat(np.arange(runs), each)
    x = np.tile(np.linspace(0, 1, each), runs)
    jac = np.column_stack([np.ones_like(x), x])
    for _ in range(300):
        shift, tilt = rng.normal(0, 1, runs)[index], rng.normal(0, 0.5, runs)[index]
        y = 2.0 + 3.0 * x + shift + tilt * x + rng.normal(0, 0.3, len(x))
        fit = np.linalg.lstsq(jac, y, rcond=None)[0]
        cover = run_covariance(jac, y - jac @ fit, index)
        one = Estimate("slope", fit[1], std_error=cover.std_error[1], dof=cover.dof[1])
        low, high = one.interval()
        hits += low <= 3.0 <= high
    assert 0.85 <= hits / 300 <= 0.95


def test_confusion_names_the_pair_and_the_run_that_would() -> None:
    x, sizes = np.array([0.0, -0.2, 0.0, -0.2]), np.array([1.0, 1.0, 3.0])
    jac = 30.0 * np.column_stack([np.ones(4), x, x**2])
    offers = [
        Candidate("more of the same", "levels", jac[:2]),
        Candidate("a third level", "2 levels", 30.0 * np.array([[1.0, 0.3, 0.09]])),
    ]
    found, open_mask = confusions(("A", "B", "C"), jac, sizes, np.eye(3), lambda: offers)
    assert list(open_mask) == [False, True, True]
    assert found[0].statement == "B and C cannot be told apart with 2 levels"
    assert found[0].remedy == "measure a third level"
    more = np.vstack([jac, 30.0 * np.array([[1.0, 0.3, 0.09]])])
    assert confusions(("A", "B", "C"), more, sizes, np.eye(3), lambda: offers)[0] == []


def test_cells_mean_what_lies_in_them() -> None:
    x = np.sort(np.random.default_rng(1).uniform(-0.1, 1.0, 3000))
    centres, means = bin_means(x, np.array([3.0 * x, np.ones_like(x)]), 0.01)
    np.testing.assert_allclose(means[0], 3.0 * centres, atol=6e-3)
    np.testing.assert_allclose(means[1], 1.0)
    with pytest.raises(FlatplankError, match="too few"):
        bin_means(x[:5], x[:5])


def test_quantities_of_chapter_7() -> None:
    x = np.arange(0.0, 3.0, 0.001)
    response = 1000.0 * -np.expm1(-x / 0.4)
    # slope/F_ss = exp(-x/sigma)/sigma = 0.05 at x = sigma ln(1/(0.05 sigma))
    end = transient_end(x, response, 1000.0)
    assert end == pytest.approx(0.4 * math.log(1.0 / (0.05 * 0.4)), abs=0.002)
    weights = transient_weights(x - 0.5, end)
    assert weights[0] == 0.0
    assert set(weights[x >= 0.5]) == {100.0, 1.0}
    assert transient_end(x, response, 0.0) == x[-1]
    assert rmse(response + 3.0, response) == pytest.approx(3.0)
    assert relative_error(np.array([100.0, -50.0]), np.array([90.0, -45.0])) == pytest.approx(0.1)


def test_results_are_plain_for_json() -> None:
    one = Estimate("c", 2.0, "N", 0.1, dof=1e9)
    low, high = one.interval(0.90)
    assert (low, high) == pytest.approx((2.0 - 0.16449, 2.0 + 0.16449), abs=1e-4)
    fit = Fit("m", (one,), np.eye(1))
    assert fit.to_json()["rmse"] is None
    assert to_plain({"a": np.array([1.0, np.nan])}) == {"a": [1.0, None]}
