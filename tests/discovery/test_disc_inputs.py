# SPDX-License-Identifier: Apache-2.0
"""Channels as inputs of the model: what runs share is kept, what one run shows alone is not."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.contact_patch.denoising import Common, as_input, as_load

RUNS, CONDITIONS = 27, 9
X = np.linspace(0.0, 4.0, 500)


def _common() -> Common:
    position = np.broadcast_to(X, (RUNS, len(X))).copy()
    start = np.radians(120.0 * (np.arange(RUNS) % 3))
    groups = [np.arange(3 * c, 3 * c + 3) for c in range(CONDITIONS)]
    return Common(position, position / 0.31 + start[:, None], [np.arange(RUNS)], groups)


def _noise(rng, size: float) -> np.ndarray:
    """Slow noise: sums of a few waves of their own in every run."""
    out = np.zeros((RUNS, len(X)))
    for k in range(1, 12):
        phase = rng.uniform(0.0, 2.0 * np.pi, (RUNS, 1))
        out += rng.standard_normal((RUNS, 1)) * np.cos(1.3 * k * X + phase) / np.sqrt(k)
    return size * out / out.std()


def _shared(common: Common) -> np.ndarray:
    condition = np.repeat(np.arange(CONDITIONS), 3)[:, None]
    after = (X > 1.5) * (1.0 - np.exp(-(X - 1.5) / 0.2))
    return 6.0 * np.sin(X / 0.25) + 9.0 * np.cos(common.turn - 0.4) + condition * after


def test_an_input_loses_its_noise_and_keeps_what_runs_share():
    common, rng = _common(), np.random.default_rng(1)
    truth = _shared(common)
    noise = _noise(rng, 3.0)
    found = as_input(truth + noise, common)
    left = found - truth
    left = left - left.mean(axis=1, keepdims=True)
    kept = float(np.sqrt(np.mean((truth - truth.mean(axis=1, keepdims=True)) ** 2)))
    assert float(np.sqrt(np.mean(left**2))) < 0.45 * 3.0
    # no size is attenuated: the share of the truth in what is fed in
    mean = found - found.mean(axis=1, keepdims=True)
    about = truth - truth.mean(axis=1, keepdims=True)
    assert float(np.sum(mean * about) / np.sum(mean**2)) == pytest.approx(1.0, abs=0.05)
    assert kept > 3.0


def test_without_noise_nothing_is_lost():
    common = _common()
    truth = _shared(common)
    lost = as_input(truth, common) - truth
    # the level is that of the condition; a kink of 40 per metre is rounded over 2 cm
    lost = np.abs(lost - lost.mean(axis=1, keepdims=True))
    assert lost.max() < 0.4 * 40.0 * 0.02
    assert lost[:, np.abs(X - 1.5) > 0.1].max() < 0.1


def test_a_load_keeps_level_and_drift_of_each_run():
    common, rng = _common(), np.random.default_rng(2)
    own = rng.uniform(-60.0, 60.0, (RUNS, 1)) + rng.uniform(-20.0, 20.0, (RUNS, 1)) * (X - 2.0)
    truth = 3700.0 + _shared(common) + own
    found = as_load(truth + _noise(rng, 5.0), common)
    assert np.abs((found - truth).mean(axis=1)).max() < 5.0
    assert float(np.sqrt(np.mean((found - truth) ** 2))) < 4.0


def test_a_condition_without_repeats_gives_no_shape_of_its_own():
    common = _common()
    lone = Common(common.position, common.turn, common.grids, [np.array([i]) for i in range(RUNS)])
    rng = np.random.default_rng(3)
    values = _noise(rng, 3.0)
    assert float(np.std(as_input(values, lone) - values.mean(axis=1, keepdims=True))) < 1.2
