# SPDX-License-Identifier: Apache-2.0
"""The error where effects were not fitted stands beside that of the fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ball import Drag, Shake, throw
from shapes import LONG, OTHER, TIME, Sum, measured

from flatplank_analysis.discovery import heldout
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import ParameterSet
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


def _by_hand(
    model: Sum, hidden: list[np.ndarray], weight=1.0, judged=1.0
) -> tuple[float, float, float]:
    """Squared errors of a straight line and some columns (channels, runs, samples): without the
    columns, with sizes from the other conditions, and as fitted to all.

    weight: of the channels in the fits; judged: in the errors.
    """
    runs, y = model.runs, model.runs.measured
    line = [np.ones_like(y), TIME + 0.0 * y]

    def fitted(columns, goal):
        flat = np.reshape([c * weight for c in columns], (len(columns), -1)).T
        sizes = np.linalg.lstsq(flat, (goal * weight).ravel())[0]
        return sizes, goal - np.tensordot(sizes, columns, axes=1)

    def square(residual):
        return np.sum((residual * judged) ** 2)

    all_sizes, everywhere = fitted([*line, *hidden], y)
    effects, left_out = np.tensordot(all_sizes[2:], hidden, axes=1), 0.0
    for rows in runs.groups:
        elsewhere = ~np.isin(np.arange(runs.runs), rows)[:, None]
        goal = np.where(elsewhere, y, y - effects)  # the line is that of all conditions
        sizes = fitted([*line, *(h * elsewhere for h in hidden)], goal)[0][2:]
        rest = y - np.tensordot(sizes, hidden, axes=1)
        left_out += square(fitted(line, rest)[1][:, rows])
    return square(fitted(line, y)[1]), left_out, square(everywhere)


class Both(Sum):
    """Two channels of one line; the second one feels a third of the effects."""

    def predict(self, sets):
        first = super().predict(sets)[:, :1]
        bare = super().predict([ParameterSet(one.base) for one in sets])[:, :1]
        return np.concatenate([first, bare + (first - bare) / 3.0], axis=1)


def test_gains_count_in_floors_and_the_error_in_the_first_channel():
    """Sizes and line are those of the fit's weights."""
    sizes = 0.1 + 0.06 * np.sin(5.0 * np.arange(24) // 3)
    x = measured(42, (sizes, LONG.form)).runs
    y = measured(43, (0.01, LONG.form), noise=0.3).runs.measured + 0.1
    model = Both(replace(x, channels=("x", "y"), measured=np.concatenate([x.measured, y])))
    weight = np.array([2.0, 3.0])[:, None, None]
    fitter = Fitter(model, weight)
    fit = fitter.fit(start_base(model), [Term(LONG, np.array([0.1]))])
    state = make_state(model, fitter, fit, [])
    h = LONG.form(model.setting)
    column = np.stack([h, h / 3.0])
    floors = np.array([1.0 / f.floor for f in state.floors])[:, None, None]
    bare, elsewhere, _ = _by_hand(model, [column], weight, floors)
    assert heldout.gain(state, fit, 0) == pytest.approx(1.0 - elsewhere / bare, rel=1e-3)
    _, elsewhere, everywhere = _by_hand(model, [column], weight, np.eye(2)[0][:, None, None])
    assert elsewhere > everywhere
    fitted = state.runs.rmse(state.residual[0]) ** 2
    wanted = np.sqrt(fitted + (elsewhere - everywhere) / 24 / 120)
    assert heldout.rmse(state) == pytest.approx(wanted, rel=1e-5)


def test_held_out_is_what_sizes_from_elsewhere_leave():
    """Sizes that differ from condition to condition, so that those from elsewhere are wrong."""
    sizes = 0.1 + 0.06 * np.sin(5.0 * np.arange(24) // 3)
    model = measured(30, (sizes, LONG.form), (0.05, OTHER.form))
    state = _state(model, LONG, OTHER)
    columns = [np.array(e.form(model.setting))[None] for e in (LONG, OTHER)]
    bare, elsewhere, everywhere = _by_hand(model, columns)
    wanted = np.sqrt(state.runs.rmse(state.residual[0]) ** 2 + (elsewhere - everywhere) / 24 / 120)
    assert elsewhere > 1.01 * everywhere
    assert heldout.rmse(state) == pytest.approx(wanted, rel=1e-5)
    one = _state(model, LONG)
    bare, elsewhere, _ = _by_hand(model, columns[:1])
    assert heldout.gain(one, one.fit, 0) == pytest.approx(1.0 - elsewhere / bare, rel=1e-4)
