# SPDX-License-Identifier: Apache-2.0
"""E-values of runs that had no part in the bet: small where nothing is missing, large where it is.

The effect that is bet on is the likeliest of the whole library, whatever the tests say of it, so
every loop bets at every batch."""

from __future__ import annotations

import math

import pytest

from flatplank_analysis.investigation.evidence import ALPHA, Evidence, e_value_words
from flatplank_sim.sealed.menu import MENU
from flatplank_validation.investigate.fast import FastBench
from flatplank_validation.investigate.nulls import evidence_of

pytestmark = pytest.mark.timeout(900)  # whole fits: a busy machine takes minutes


def test_the_product_may_be_looked_at_after_every_batch():
    total = Evidence()
    for log in (1.0, 1.0, 1.0):
        assert not total.enough
        total = total.with_batch(log, True)
    assert total.enough
    assert (total.log, total.batches) == (3.0, 3)
    assert total.e_value == pytest.approx(math.exp(3.0))
    assert total.with_batch(0.0, False).batches == 3
    assert e_value_words(3.0) == "e = 20.1"
    assert e_value_words(207.0) == "e = 10^90"
    assert (e_value_words(1e5), e_value_words(-1e5)) == ("e > 10^99", "e < 10^-99")


def test_an_effect_that_is_there_is_told_from_the_tire_alone():
    hidden = MENU["drive_brake_asymmetry"]
    product = evidence_of(FastBench(5, hidden.defects(0.12)))
    assert max(product) > -math.log(ALPHA)


def _false(seeds) -> int:
    """Loops in which the product passed 1/alpha at any of its three batches."""
    return sum(max(evidence_of(FastBench(seed))) >= -math.log(ALPHA) for seed in seeds)


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_nothing_is_told_in_a_hundred_nulls():
    # 5 are allowed on average; 10 or more come with a chance of 3 %
    assert _false(range(1001, 1101)) < 10
