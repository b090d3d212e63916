# SPDX-License-Identifier: Apache-2.0
"""Counters: wrapping and the exact least-squares slope."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_hw.encoders.counter import SlopeCounter, counts_between, wrapped


@pytest.mark.parametrize("start", [0, 2**31 - 5, -(2**31), 2**40 + 17])
@pytest.mark.parametrize("step", [1, -1, 7, -300_000, 2**30])
def test_unwrapping_over_the_end_of_the_32_bits(start, step):
    counter = SlopeCounter(4)
    first = wrapped(start)
    for k in range(50):
        counter.update(wrapped(start + k * step))
        assert counter.counts - first == k * step
    assert counts_between(wrapped(start), wrapped(start + step)) == step
    assert counter.slope == step


@pytest.mark.parametrize("n", [2, 5, 25])
def test_slope_is_that_of_polyfit(n):
    rng = np.random.default_rng(n)
    counts = np.cumsum(rng.integers(-50, 90, 400))
    counter = SlopeCounter(n)
    for k, c in enumerate(counts):
        counter.update(int(c))
        if k >= n:
            wanted = np.polyfit(np.arange(n), counts[k - n + 1 : k + 1], 1)[0]
            assert counter.slope == pytest.approx(wanted, rel=1e-9, abs=1e-9)
            assert counter.back(n - 1) == counts[k - n + 1]
            assert counter.back(1) == counts[k - 1]


def test_sums_do_not_drift():
    counter = SlopeCounter(25)
    for k in range(20_000):
        counter.update(wrapped(987_654 * k))
    assert counter.slope == 987_654


def test_noise_of_the_slope_is_that_of_the_docstring():
    n = 25
    rng = np.random.default_rng(3)
    errors = []
    for slope, start in zip(rng.uniform(2, 12, 2000), rng.uniform(0, 1, 2000), strict=True):
        counter = SlopeCounter(n)
        for k in range(n + 1):
            counter.update(int(np.floor(start + slope * k)))
        errors.append(counter.slope - slope)
    assert np.std(errors) == pytest.approx(1.0 / np.sqrt(n * (n**2 - 1)), rel=0.1)
