# SPDX-License-Identifier: Apache-2.0
"""A fault of another form than any effect: what is named, and what is not."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import LONG, OTHER, TIME, Hum, Hummed, measured, names, searched, shape, wave

from flatplank_analysis.discovery.fit import Fitter, Term, fit_whitened
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND, LAW, NONE, PARTLY, diagnose


def bent(c: np.ndarray, periods: float = 1.5, much: float = 0.8) -> np.ndarray:
    """As LONG, but from 0.2 to 1.8 times as large along the run."""
    return (1.0 + 0.5 * c) * (1.0 + 0.5 * much * (TIME - 2.0)) * wave(periods)


def test_a_fault_of_another_form_is_named_with_a_wide_interval():
    """The size differs along the run by a factor of nine; 15 % are what a fault usually has."""
    search = searched(measured(18, (0.06, lambda c: bent(c, much=0.2))), LONG, OTHER)
    (found,) = search.last.found
    assert names([found]) == {"long"}
    low, high = found.decision.interval
    assert low < 0.06 < high and high - low > 0.005
    assert diagnose(search).verdict == FOUND


def test_what_a_wrong_form_leaves_is_told():
    """The name of most of it, and that more is left."""
    for much, verdicts in ((0.2, {FOUND}), (1.2, {PARTLY, NONE})):
        model = measured(18, (0.2, lambda c, much=much: bent(c, much=much)))
        search = searched(model, LONG, OTHER)
        assert names(search.last.found) <= {"long"}
        assert diagnose(search).verdict in verdicts


def test_a_small_effect_beside_one_of_another_form_is_named():
    second = measured(18, (0.1, lambda c: bent(c, much=0.2)), (0.06, OTHER.form))
    search = searched(second, LONG, OTHER)
    assert names(search.last.found) == {"long", "other"}


def test_a_law_that_explains_nothing_of_consequence_is_not_added():
    law = shape("law", LONG.form, generic=True)
    for size, said, told in ((0.002, AT_FLOOR, set()), (0.03, LAW, {"law"})):
        search = searched(measured(21, (size, LONG.form)), law)
        result = diagnose(search)
        assert result.verdict == said and names(result.found) == names(search.last.found) == told


def test_the_columns_of_the_whitened_fit_are_those_at_its_own_parameters():
    """The fit itself ends with columns of an earlier iteration, where the pitch was another."""
    model = Hummed(measured(23, (0.1, lambda c: np.sin(2.0 * np.pi * 0.95 * TIME))).runs)
    fitter = Fitter(model, channel_weights(model, [0.05]))
    start = fitter.fit(start_base(model), [Term(Hum, np.array([0.1, 0.9]))], iterations=0)
    state = make_state(model, fitter, start, [])
    found = state.whitened.fit
    assert found.terms[0].values[1] == pytest.approx(0.95, abs=0.01)
    wanted = fitter.derivative(found).jacobian
    np.testing.assert_allclose(found.jacobian, wanted, atol=1e-9)
    early = fit_whitened(state.metric, fitter, start).fit.jacobian
    assert np.abs(early - wanted).max() > 0.01 * np.abs(wanted).max()
