# SPDX-License-Identifier: Apache-2.0
"""The error where effects were not fitted stands beside that of the fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ball import Drag, Shake, throw

from flatplank_analysis.discovery import heldout
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base


def _state(ball, *effects):
    fitter = Fitter(ball, channel_weights(ball, [0.02]))
    terms = [Term(e, np.array([e.parameters()[0].screen])) for e in effects]
    return make_state(ball, fitter, fitter.fit(start_base(ball), terms), [])


@pytest.fixture
def held_back():
    """A ball whose camera was later than the base may be: what a base without its range would
    take is no merit of an effect."""
    ball = throw(1, 0.02)
    late = replace(ball.parameters[1], upper=-0.02)
    ball.parameters = (ball.parameters[0], late)
    return ball


def test_an_effect_of_no_use_shows_no_fall(held_back):
    drag, both = _state(held_back, Drag), _state(held_back, Drag, Shake)
    assert "late" in drag.fit.at_bound
    before, after = heldout.rmse(drag), heldout.rmse(both)
    fitted = held_back.runs.rmse(both.residual[0])
    assert after >= fitted
    assert after > 0.999 * before
    assert heldout.gain(both, both.fit, 1) < 0.002


def test_an_effect_that_is_there_shows_its_fall(held_back):
    without, with_ = _state(held_back), _state(held_back, Drag)
    assert heldout.rmse(without) == held_back.runs.rmse(without.residual[0])
    fitted = held_back.runs.rmse(with_.residual[0])
    assert fitted <= heldout.rmse(with_) < 1.1 * fitted
    assert heldout.rmse(with_) < 0.7 * heldout.rmse(without)
    assert heldout.gain(with_, with_.fit, 0) > 0.5


def test_the_least_within_a_range_where_directions_are_nearly_alike():
    rng = np.random.default_rng(5)
    columns = rng.standard_normal((200, 6)) * [1.0, 30.0, 0.1, 1.0, 1.0, 5.0]
    columns[:, 3] = columns[:, 4] + 1e-3 * rng.standard_normal(200)
    hessian, slope = columns.T @ columns, columns.T @ (3.0 * rng.standard_normal(200))
    low, high = np.full(6, -0.05), np.array([0.05, 0.0, np.inf, 0.4, np.inf, 0.05])
    x = heldout._least(hessian, slope, low, high, np.sqrt(np.diag(hessian)))
    pull = slope - hessian @ x
    tolerance = 1e-3 * np.sqrt(np.diag(hessian))
    assert np.all(x >= low - 1e-9) and np.all(x <= high + 1e-9)
    assert np.all(pull[x > low + 1e-6] > -tolerance[x > low + 1e-6])
    assert np.all(pull[x < high - 1e-6] < tolerance[x < high - 1e-6])
