# SPDX-License-Identifier: Apache-2.0
"""The simulated machine of the thesis shows what the thesis published; plant and fits share
no code.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "validation/benchmarks"


@pytest.fixture(scope="module")
def bench():
    sys.path.insert(0, str(BENCHMARKS))
    try:
        yield importlib.import_module("published_pattern")
    finally:
        sys.path.remove(str(BENCHMARKS))


@pytest.fixture(scope="module")
def pattern(bench):
    return bench.measure(seed=7)


def at(bench, values, percent: float) -> float:
    return float(values[bench.SLIPS.index(percent / 100.0)])


def test_relaxation_of_small_driving_steps_is_longer(bench, pattern) -> None:
    for size in (1, 2):
        driving, braking = (at(bench, pattern.sigma, s * size) for s in (1, -1))
        assert driving > 1.1 * braking


def test_cut_play_helps_every_step_but_the_small_braking_ones(bench, pattern) -> None:
    """Seven signs of Table 7.3 need nothing but the play."""
    same = pattern.signs(pattern.cut)
    wrong = [k for k, ok in zip(bench.SLIPS, same, strict=True) if not ok]
    assert wrong == [-0.02, -0.01]


def test_small_braking_steps_get_worse_with_the_larger_plateau_of_those_runs(bench, pattern):
    """All signs but that of the run without slip, which the thesis has at -6 N."""
    same = pattern.signs(pattern.larger)
    assert [k for k, ok in zip(bench.SLIPS, same, strict=True) if not ok and k] == []
    change = pattern.larger - pattern.before
    assert at(bench, change, -2.0) > 1.0 and at(bench, change, 2.0) < -3.0
