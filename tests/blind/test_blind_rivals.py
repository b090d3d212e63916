# SPDX-License-Identifier: Apache-2.0
"""What one would do today gets what it can have: a verdict, a group, an honest sample count."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from flatplank_validation.blind.rivals import alike_with, samples_of, verdict


def test_samples_that_repeat_their_neighbours_count_less():
    random = np.random.default_rng(1)
    white = random.standard_normal((2, 6, 4000))
    assert samples_of(white) == pytest.approx(white.size, rel=0.05)
    slow = lfilter([1.0], [1.0, -0.9], white)
    assert samples_of(slow) == pytest.approx(white.size * 0.1 / 1.9, rel=0.1)


def test_the_verdict_is_that_of_the_error_and_the_repeats():
    one = {"name": "wear", "class": []}
    group = {"name": "wear", "class": ["tread"]}
    law = {"name": "tire_law", "class": []}
    assert verdict([], 10.0, 10.0) == "at floor"
    assert verdict([law], 10.0, 10.0) == "tire law only"
    assert verdict([one, law], 10.0, 10.0) == "found"
    assert verdict([one, group], 10.0, 10.0) == "found group"
    assert verdict([group], 20.0, 10.0) == "partly"
    assert verdict([law], 20.0, 10.0) == verdict([], 20.0, 10.0) == "none of these"


def test_a_group_holds_what_looks_nearly_the_same():
    random = np.random.default_rng(2)
    mine, other = random.standard_normal((2, 500))
    columns = [
        ("mine", mine[None]),
        ("twin", (mine + 0.2 * other)[None]),
        ("pair", np.array([mine + other, other])),
        ("far", (mine + other)[None]),
        ("tire_law", mine[None]),
    ]
    assert alike_with(2.0 * mine, columns, "mine") == ["pair", "twin"]
