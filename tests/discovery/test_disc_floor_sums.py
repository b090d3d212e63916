# SPDX-License-Identifier: Apache-2.0
"""The floor and its degrees of freedom, against the same numbers in plain linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from draws import RUNS, numbers
from scipy.stats import f as f_distribution
from shapes import CONDITIONS, REPEATS, measured

from flatplank_analysis.discovery import floor


def test_contrasts_lose_what_differs_between_repeats_and_is_known():
    runs = measured(0).runs
    form, noise = numbers(12, runs.samples), numbers(13, RUNS, runs.samples)
    sizes = np.tile([1.0, 0.5, -2.0], CONDITIONS)
    block = sizes[None, :, None] * form
    shared = np.ones((1, RUNS, 1)) * form
    assert len(floor.contrast_blocks(runs, [block, shared, 0.0 * block])) == 1
    slight = shared + 0.4 * block / np.std(sizes)
    assert not floor.contrast_blocks(runs, [slight])
    # a share of 0.51 counts and one of 0.49 does not, in whatever unit
    turned = (sizes - np.mean(sizes))[None, :, None] / np.std(sizes) * form
    for scale in (0.01, 1.0, 100.0):
        for share, kept in ((0.49, 0), (0.51, 1)):
            mixed = scale * (share * turned + np.sqrt(1.0 - share**2) * shared)
            assert len(floor.contrast_blocks(runs, [mixed])) == kept

    def cleaned(runs, residual, blocks):
        return floor.clean_contrasts(runs, residual, floor.contrast_blocks(runs, blocks))

    def left(residual, blocks):
        return cleaned(runs, residual, blocks).contrasts

    found = left(noise + 3.0 * block[0] + 5.0 * shared[0], [block, shared])
    flat = runs.contrast(block).ravel()
    pure = runs.contrast(noise).ravel()
    pure = pure - flat * (flat @ pure) / (flat @ flat)
    np.testing.assert_allclose(found.ravel(), pure, atol=1e-5)
    other = numbers(14, 1, RUNS, runs.samples)
    both = left(noise + 3.0 * block[0] + other[0], [other, block])
    assert np.std(both) == pytest.approx(np.std(runs.contrast(noise)), rel=0.01)
    twice = left(noise + 3.0 * block[0], [np.concatenate([block, block])])
    np.testing.assert_allclose(twice.ravel(), pure, atol=1e-5)
    for unit in (1e-3, 1e3):
        scaled = left(unit * (noise + 3.0 * block[0] + other[0]), [1e4 * other, 1e-4 * block])
        np.testing.assert_allclose(scaled, unit * both, rtol=1e-6, atol=unit * 1e-6)
    # contrasts without anything left are no reason to look on
    assert not left(0.0 * noise, [block]).any()
    # noise is not explained by what happens to look a little like it
    kept = cleaned(runs, noise, [block, other])
    np.testing.assert_allclose(kept.contrasts, runs.contrast(noise))
    assert kept.p_value == 1.0
    assert np.abs(left(shared[0], [block])).max() < 1e-12


def test_conditions_with_more_repeats_are_no_more_uneven():
    """Two repeats here and three there, and the same scatter: the conditions have equal parts."""
    runs = measured(0).runs.subset(np.delete(np.arange(RUNS), np.arange(0, RUNS, 2 * REPEATS)))
    contrast = runs.contrast(numbers(19, runs.runs, runs.samples))
    for group in runs.groups:
        contrast[group] *= np.sqrt((len(group) - 1) / np.sum(contrast[group] ** 2))
    spare = runs.runs - CONDITIONS
    thin = contrast.T @ contrast
    ratio = np.trace(thin) ** 2 / np.sum(thin**2)
    per_run = 1.0 / max(1.0 / ratio - 1.0 / spare, 1.0 / 200.0)
    assert floor.effective_freedom(runs, contrast) == pytest.approx(spare * per_run)


def test_the_floor_and_what_is_beyond_it():
    runs = measured(0).runs.subset(np.arange(1, RUNS))
    counts = np.array([2.0] + [3.0] * (CONDITIONS - 1))
    spare = float(np.sum(counts - 1.0))
    contrast = 2.0 * runs.contrast(numbers(18, RUNS - 1, runs.samples))
    mean = np.linspace(1.0, 4.0, CONDITIONS)
    residual = contrast + mean[runs.condition][:, None]
    cleaned = floor.Cleaned(0.8 * contrast, 2e-4)
    pure = np.sum(cleaned.contrasts**2) / (spare * runs.samples)
    found = floor.floor_of(runs, residual, cleaned, per_run=50.0)
    assert found.floor == pytest.approx(np.sqrt(pure))
    assert found.raw == pytest.approx(found.floor / 0.8)
    assert found.varying == pytest.approx(0.75 * found.floor) and found.varying_p == 2e-4
    beyond = mean**2 - pure / counts
    own = [np.mean(cleaned.contrasts[g] ** 2) * len(g) / (len(g) - 1) for g in runs.groups]
    np.testing.assert_allclose(found.by_condition**2, own)
    np.testing.assert_allclose(
        found.per_condition, np.sqrt(np.maximum(mean**2 - own / counts, 0.0))
    )
    np.testing.assert_allclose(found.multiples * found.by_condition, found.rmse_condition)
    assert [row["own_floor"] for row in found.rows(runs)] == [True] * CONDITIONS
    assert found.unexplained == pytest.approx(np.sqrt(counts @ beyond / counts.sum()))
    np.testing.assert_allclose(found.rmse_condition[0], np.sqrt(np.mean(residual[:2] ** 2)))
    assert found.freedom == pytest.approx(
        min(spare * 50.0, floor.effective_freedom(runs, cleaned.contrasts))
    )
    ratio = np.mean(mean**2 * counts) / pure
    wanted = f_distribution.sf(ratio, found.freedom * CONDITIONS / spare, found.freedom)
    assert found.p_value == pytest.approx(wanted)
    few = floor.floor_of(runs, 0.3 * residual, cleaned, per_run=0.5)
    assert few.freedom == spare * 0.5 and 0.0 < few.p_value < 1.0
    ratio *= 0.09
    assert few.p_value == pytest.approx(
        f_distribution.sf(ratio, few.freedom * CONDITIONS / spare, few.freedom)
    )
    # steps of the inputs repeat themselves; and a floor that is known is no smaller
    stepped = floor.floor_of(replace(runs, input_noise=(0.5,)), residual, cleaned)
    assert stepped.unexplained**2 == pytest.approx(found.unexplained**2 - 0.25)
    stepped = floor.floor_of(
        replace(runs, input_noise=(0.5,)), 0.3 * residual, cleaned, per_run=0.5
    )
    ratio = np.mean(np.maximum(0.09 * mean**2 - 0.25, 0.0) * counts) / pure
    assert stepped.p_value == pytest.approx(
        f_distribution.sf(ratio, few.freedom * CONDITIONS / spare, few.freedom)
    )
    assert floor.floor_of(runs, residual, cleaned, least=9.0).floor == pytest.approx(9.0)
    # a condition that is not repeated has the floor of all
    few_runs = measured(0).runs.subset(np.arange(2, RUNS))
    part = floor.Cleaned(few_runs.contrast(contrast[1:]))
    single = floor.floor_of(few_runs, residual[1:], part)
    assert single.by_condition[0] == single.floor != single.by_condition[1]
    assert not single.rows(few_runs)[0]["own_floor"]
    # no error is below the floor, and no scatter below none
    below = floor.floor_of(runs, 0.1 * contrast, cleaned)
    assert below.unexplained == 0.0 and below.varying == 0.0
    assert not below.per_condition.any()
