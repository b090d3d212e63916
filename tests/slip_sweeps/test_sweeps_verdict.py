# SPDX-License-Identifier: Apache-2.0
"""The chance that the verdict on a tire file states is the one with which it errs."""

from __future__ import annotations

import formula_of_sweeps as tire
import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

from flatplank_analysis.slip_sweeps.conditions import BINS
from flatplank_analysis.slip_sweeps.study import study
from flatplank_analysis.slip_sweeps.verdict import (
    RELAXATION,
    RISK,
    chance_of,
    degrees_of_freedom,
    fails,
)
from flatplank_tire.tir import read_tir

DRAWS = 2000


def drawn_chances(
    memory: float, counts: np.ndarray, smooth: int = 0, lag: float = 0.0
) -> np.ndarray:
    """Chances of an exact file; memory: correlation of neighbouring bins of one pass; lag:
    difference of the passes that is no scatter."""
    random = np.random.default_rng(7)
    found = []
    for _ in range(DRAWS):
        noise = random.standard_normal((2, BINS + 50))
        passes = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], noise)[:, 50:]
        passes = passes / np.sqrt(counts / 2)
        error = np.sqrt(np.mean(passes.mean(axis=0) ** 2))
        difference = passes[0] - passes[1] + lag * np.sin(np.linspace(0.0, np.pi, BINS))
        floor = 0.5 * np.sqrt(np.mean(difference**2))
        found.append(chance_of(error, floor, degrees_of_freedom(difference, counts, smooth)))
    return np.array(found)


EVEN = np.full(BINS, 40.0)
SINE = 40.0 / np.sqrt(1.0 - np.linspace(-0.97, 0.97, BINS) ** 2)


@pytest.mark.parametrize("counts", [EVEN, SINE], ids=["even", "sine"])
@pytest.mark.parametrize("smooth", [0, RELAXATION], ids=["repeats", "ways"])
@pytest.mark.parametrize("memory", [0.0, 0.3, 0.6])
def test_an_exact_file_fails_as_rarely_as_stated(memory, smooth, counts):
    """Scatter with a memory is known from 30 bins only: it may double the chance."""
    for stated in (0.01, 0.1):
        failed = int((drawn_chances(memory, counts, smooth) < stated).sum())
        assert failed < binom.ppf(0.9999, DRAWS, (2.0 if memory else 1.0) * stated)
        assert failed > binom.ppf(0.0001, DRAWS, 0.25 * stated)


def test_a_difference_of_the_passes_makes_the_verdict_milder_and_does_not_blind_it():
    chances = drawn_chances(0.0, EVEN, RELAXATION, lag=0.5)
    assert (chances < 0.01).mean() < 0.01
    bump = 2.0 * np.sin(np.linspace(0.0, np.pi, BINS))
    noise = 0.2 * np.random.default_rng(1).standard_normal(BINS)
    freedom = degrees_of_freedom(bump + noise, EVEN, RELAXATION)
    assert freedom > 15.0


def test_the_risk_is_that_of_all_conditions_together():
    assert fails([0.009]).all() and not fails([0.009] * 3).any()
    chances = np.random.default_rng(3).uniform(size=(20_000, 12))
    assert np.mean([fails(row).any() for row in chances]) == pytest.approx(RISK, abs=0.003)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("wrong", [0.0, 0.01])
def test_a_file_that_is_one_percent_off_fails_and_an_exact_one_does_not(tmp_path, seed, wrong):
    """1 % of 2832 N is 28 N, the floor is 1 N."""
    columns = tire.sweep(tire.wave(480), seed=seed)
    columns["FY"] = columns["FY"] * (1.0 + wrong)
    path, tir = tire.files(tmp_path, tire.text_of(columns))
    found = fails([f.chance for f in study(path).failures(read_tir(str(tir)))])
    assert found.all() if wrong else not found.any()


def test_without_a_floor_there_is_no_verdict():
    assert np.isnan(chance_of(1.0, float("nan"), float("nan")))
    assert np.isnan(degrees_of_freedom(np.full(BINS, np.nan), EVEN))
    assert not fails([float("nan")]).any()
