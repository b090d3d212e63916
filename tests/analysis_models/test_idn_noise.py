# SPDX-License-Identifier: Apache-2.0
"""Autoregressive noise: closed forms of the first order, and differences between repeats."""

from __future__ import annotations

import numpy as np
import pytest
from idn_runs import numbers

from flatplank_analysis.identify.noise import (
    ARNoise,
    _burg,
    _stable,
    fit_noise,
    repeat_differences,
)


def test_numbers_of_a_first_order_noise():
    noise = ARNoise((0.8,), 3.0, 1000)
    assert noise.gain == pytest.approx(5.0)
    assert noise.std == pytest.approx(3.0 / 0.6)
    assert noise.effective_samples == pytest.approx(1000.0 * 0.2 / 1.8)
    assert ARNoise((), 0.0, 50).effective_samples == 50.0
    assert ARNoise((1.0,), 1.0, 9).gain == 1e3
    # an endless memory is cut, a short one stays
    np.testing.assert_allclose(_stable(np.array([1.1])), [0.999])
    np.testing.assert_allclose(_stable(np.array([0.5, 0.2])), [0.5, 0.2])
    assert _stable(np.zeros(0)) == ()
    found = fit_noise([noise.colour(3.0 * w) for w in numbers(6, 20, 2000)])
    assert found.coefficients[0] == pytest.approx(0.8, abs=0.02)
    assert found.innovation == pytest.approx(3.0, rel=0.02) and found.samples == 40000
    assert (
        len(fit_noise([noise.colour(w) for w in numbers(6, 5, 2000)], order=2).coefficients) == 2
    )
    short = fit_noise([np.array([3.0, -4.0])])
    assert (short.coefficients, short.samples) == ((), 2)
    assert short.innovation == pytest.approx(12.5**0.5)
    assert fit_noise([]).samples == 1
    assert fit_noise([np.full(40, 5.0), np.full(60, -5.0)]) == ARNoise((), 5.0, 100)


def test_differences_between_repeats_have_the_variance_of_one_run():
    group = numbers(7, 3, 5000) + 50.0
    found = repeat_differences([group, group[:1]])
    assert len(found) == 3
    assert np.mean(np.square(found)) == pytest.approx(1.0, rel=0.05)
    two = repeat_differences([group[:2]])
    np.testing.assert_allclose(two[0], (group[0] - group[1]) / 2.0**0.5)


def test_covariance_of_scores_with_the_matrix_written_out():
    """e = A^-1 w: J' A^-1 A^-T J s^2, A with ones and -a_k below the diagonal."""
    noise, n = ARNoise((0.6, -0.3), 2.5, 100), 12
    a = np.eye(n) - 0.6 * np.eye(n, k=-1) + 0.3 * np.eye(n, k=-2)
    jac = numbers(14, n, 3)
    spread = np.linalg.inv(a) @ np.linalg.inv(a).T * 2.5**2
    np.testing.assert_allclose(noise.score_covariance(jac), jac.T @ spread @ jac)
    white = numbers(15, 2, n)
    np.testing.assert_allclose(noise.colour(white), white @ np.linalg.inv(a).T)


def test_recursion_of_burg_written_out():
    """k = 2 sum f b / sum(f^2 + b^2) over all series, forward and backward errors anew."""
    series = [numbers(16, 40), numbers(17, 60)]
    found, variances = _burg(series, 2)
    ahead, back = [s[1:] for s in series], [s[:-1] for s in series]
    top = sum(2.0 * f @ b for f, b in zip(ahead, back, strict=True))
    one = top / sum(f @ f + b @ b for f, b in zip(ahead, back, strict=True))
    pairs = [(f - one * b, b - one * f) for f, b in zip(ahead, back, strict=True)]
    pairs = [(f[1:], b[:-1]) for f, b in pairs]
    two = sum(2.0 * f @ b for f, b in pairs) / sum(f @ f + b @ b for f, b in pairs)
    assert [len(c) for c in found] == [0, 1, 2]
    assert found[1] == pytest.approx([one])
    assert found[2] == pytest.approx([one - two * one, two])
    whole = sum(s @ s for s in series) / 100.0
    wanted = [whole, whole * (1.0 - one**2), whole * (1.0 - one**2) * (1.0 - two**2)]
    assert variances == pytest.approx(wanted)


def test_the_order_is_what_bic_takes():
    """n log(variance) + k log(n): white noise has none, a resonance two."""
    white = list(numbers(18, 30, 300))
    assert fit_noise(white).coefficients == ()
    resonance = ARNoise((1.6, -0.8), 1.0, 1)
    found = fit_noise([resonance.colour(w) for w in numbers(19, 30, 300)])
    assert found.coefficients == pytest.approx((1.6, -0.8), abs=0.03)
    for seed in range(20, 26):
        series = [resonance.colour(numbers(seed, 200))]
        coefficients, variances = _burg(series, 8)
        scores = [200 * np.log(v) + k * np.log(200) for k, v in enumerate(variances)]
        best = coefficients[int(np.argmin(scores))]
        assert fit_noise(series).coefficients == pytest.approx(tuple(best))
        assert fit_noise(series).innovation == pytest.approx(variances[len(best)] ** 0.5)
    # a series of 32 samples is too short for a memory of 8, one of 33 is not
    short, longer = numbers(27, 32) + 9.0, numbers(28, 33) + 9.0
    assert fit_noise([short]).innovation == pytest.approx(np.mean(short**2) ** 0.5)
    assert fit_noise([short]).coefficients == ()
    assert len(fit_noise([longer]).coefficients) > 0
    assert fit_noise([short, longer]).samples == 33
    assert fit_noise([np.full(50, 2.0), longer]).samples == 83


def test_an_unstable_model_is_drawn_inside_and_stays_real():
    """Poles beyond 0.999 keep their angle."""
    for pole in (1.05 * np.exp(0.7j), 0.9995 * np.exp(2.0j)):
        made = _stable(np.array([2.0 * pole.real, -(abs(pole) ** 2)]))
        drawn = 0.999 * pole / abs(pole)
        assert made == pytest.approx((2.0 * drawn.real, -(0.999**2)))
    inside = 0.99 * np.exp(0.7j)
    made = _stable(np.array([2.0 * inside.real, -(0.99**2)]))
    assert made == pytest.approx((2.0 * inside.real, -(0.99**2)))
