# SPDX-License-Identifier: Apache-2.0
"""Measures of chapter 7 on grids so coarse that every sample counts."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.identify.linear import is_transient, transient_end, transient_weights
from flatplank_analysis.identify.results import rmse

X = 0.25 * np.arange(8.0)
RESPONSE = np.array([0.0, 400.0, 600.0, 700.0, 710.0, 711.0, 712.0, 713.0])
"""slopes 1600, 1200, 600, 220, 22, 4, 4, 4 N/m"""


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("steady", "end"), [(1000.0, 1.0), (400.0, 1.25), (5000.0, 0.75)])
def test_first_sample_below_the_slope_of_five_percent_a_metre(steady, end, sign):
    assert transient_end(X, RESPONSE, sign * steady) == end
    assert transient_end(X, -RESPONSE, sign * steady) == end


def test_what_lies_before_the_step_and_before_the_steepest_place_does_not_count():
    early = np.concatenate([[-0.25], X])
    assert transient_end(early, np.concatenate([[9e3], RESPONSE]), 1000.0) == 1.0
    late = np.concatenate([np.zeros(5), RESPONSE])
    assert transient_end(0.25 * np.arange(13.0), late, 1000.0) == 1.25 + 1.0
    assert transient_end(X[:3], RESPONSE[:3], 1e9) == 0.0
    assert transient_end(X[:2], RESPONSE[:2], 1e9) == 0.25
    assert transient_end(X, RESPONSE, 2e-9) == X[-1]


def test_weights_hold_from_the_step_to_the_end_of_the_transient_part():
    x = np.array([-0.25, 0.0, 0.5, 0.75])
    assert is_transient(x, 0.5).tolist() == [False, True, True, False]
    assert transient_weights(x, 0.5).tolist() == [0.0, 100.0, 100.0, 1.0]


def test_error_of_the_chosen_samples():
    measured, modelled = np.array([1.0, 5.0, 9.0]), np.array([1.0, 2.0, 5.0])
    assert rmse(measured, modelled) == pytest.approx((25.0 / 3.0) ** 0.5)
    assert rmse(measured, modelled, np.array([False, True, False])) == 3.0
    assert np.isnan(rmse(measured, modelled, np.zeros(3, bool)))
