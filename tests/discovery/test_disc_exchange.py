# SPDX-License-Identifier: Apache-2.0
"""The exchange test among repeats: true to its level whatever the scatter is like."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.proposal.exchange import exchange_test

GROUPS = [np.arange(i, 15, 5) for i in range(5)]
RESPONSES = np.stack(
    [np.ones((15, 40)), np.repeat([5.0, 1.0, 0.1, 1.0, 5.0] * 3, 40).reshape(15, 40)]
)
"""a force that is the same everywhere, and a gain that shows in two of five conditions"""


def _runs():
    def contrast(values: np.ndarray) -> np.ndarray:
        out = np.empty_like(values)
        for g in GROUPS:
            out[g] = values[g] - values[g].mean(axis=0)
        return out

    return SimpleNamespace(groups=GROUPS, contrast=contrast)


def _scattered(random: np.random.Generator) -> np.ndarray:
    """A gain that scatters from run to run, and noise."""
    gain = random.standard_normal((15, 1)) * RESPONSES[1]
    return gain + 0.2 * random.standard_normal((15, 40))


@pytest.mark.long
def test_what_orders_nothing_is_ordered_by_chance_as_often_as_it_may():
    """Four numbers carry nearly all of the scatter: its energy passed for fourteen."""
    random = np.random.default_rng(4)
    p = [
        exchange_test(_runs(), _scattered(random), RESPONSES, random.uniform(-1.0, 1.0, 15))
        for _ in range(150)
    ]
    assert 2 <= sum(v < 0.05 for v in p) <= 15
    assert 0.4 < np.mean(p) < 0.6


def test_a_setting_that_makes_the_scatter_is_seen():
    random = np.random.default_rng(5)
    values = random.uniform(-1.0, 1.0, 15)
    noise = 0.2 * random.standard_normal((15, 40))
    assert (
        exchange_test(_runs(), noise + values[:, None] * RESPONSES[0], RESPONSES, values) < 0.002
    )
    bent = noise + (values**2)[:, None] * RESPONSES[0]
    assert exchange_test(_runs(), bent, RESPONSES, values) < 0.01
