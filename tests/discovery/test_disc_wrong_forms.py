# SPDX-License-Identifier: Apache-2.0
"""A fault of another form than any effect: what is named, and what is not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from shapes import LONG, OTHER, TIME, Sum, measured, names, refusals, searched, shape, wave

from flatplank_analysis.discovery.decide import Judge
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fitter, Term, fit_whitened
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.search import Options, _Searcher
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND, LAW, NONE, PARTLY, diagnose


def bent(c: np.ndarray, periods: float = 1.5, much: float = 0.8) -> np.ndarray:
    """As LONG, but from 0.2 to 1.8 times as large along the run."""
    return (1.0 + 0.5 * c) * (1.0 + 0.5 * much * (TIME - 2.0)) * wave(periods)


def test_a_fault_of_another_form_is_named_where_it_leaves_nothing():
    search = searched(measured(18, (0.06, bent)), LONG, OTHER)
    assert refusals(search, "long") == ("not the same size along the run",)
    (found,) = search.last.found
    assert names([found]) == {"long"}
    low, high = found.decision.interval
    assert low < 0.06 < high and high - low > 0.02
    result = diagnose(search)
    assert result.verdict == FOUND
    assert any("long: not the same size along the run" in note for note in result.notes)


def test_where_more_than_counts_is_left_the_form_must_be_nearly_right():
    for much, named, verdict in ((0.5, {"long"}, PARTLY), (1.2, set(), NONE)):
        model = measured(18, (0.2, lambda c, much=much: bent(c, much=much)))
        search = searched(model, LONG, OTHER)
        assert refusals(search, "long") == ("not the same size along the run",)
        assert names(search.last.found) == named and diagnose(search).verdict == verdict


def test_what_a_wrong_form_leaves_is_no_effect_and_hides_none():
    """The found effect may differ along the run and between conditions, as it was seen to. What
    that explains is no further effect; one of another shape may explain less and is named."""
    early = shape("early", lambda c: LONG.form(c) * (TIME < 1.6))
    fault = measured(18, (0.1, lambda c: LONG.form(c) - 0.5 * early.form(c)))
    search = searched(fault, LONG, early)
    (found,) = search.last.found
    assert names([found]) == {"long"} and found.decision.misshapen
    (refused,) = (d for d in search.last.refits if d.term.effect is early)
    assert refused.drop > 100.0
    assert refused.reasons == ("not beyond the scatter among conditions",)
    second = measured(18, (0.1, lambda c: bent(c, much=0.6)), (0.012, OTHER.form))
    search = searched(second, LONG, OTHER)
    assert names(search.last.found) == {"long", "other"}
    (first,) = search.steps[1].found
    assert search.last.found[1].decision.drop < first.decision.residue


def test_what_is_left_by_a_fault_that_no_effect_fits_is_not_named():
    """A fault in every other condition, much unlike LONG, and a small effect that imitates it."""
    fault = (0.2, lambda c: (1.0 + 0.5 * c) * wave(1.5) * (np.abs(c) > 0.5))
    like = shape("like", lambda c: wave(1.5) * (TIME < 1.0) + 0.2 * wave(7.5))
    search = searched(measured(6, fault), LONG, like)
    by_name = {d.term.effect.identifier: d for d in search.steps[0].refits}
    assert by_name["long"].drop > by_name["like"].drop
    assert not search.last.found


@dataclass(frozen=True)
class Hum(Effect):
    """A wave whose pitch is fitted, too."""

    identifier, kind, coordinate = "hum", "machine", "time"
    a: float = param(0.0, unit="1", bounds=(-5.0, 5.0), screen=0.02, matters=0.05)
    pitch: float = param(0.9, unit="1/s", bounds=(0.5, 1.5))


class Hummed(Sum):
    """Level, slope and hums: two Jacobians do not reach the pitch."""

    def part(self, effect, values):
        size, pitch = values
        return size * np.sin(2.0 * np.pi * pitch * TIME)


def test_a_promising_refit_is_carried_to_its_end():
    """The first Jacobians find less than half of the size, which does not matter."""
    model = measured(23, (0.1, lambda c: np.sin(2.0 * np.pi * 0.95 * TIME)))
    searcher = _Searcher(Hummed(model.runs), [Hum], Options())
    fit = searcher.fitter.fit(start_base(model), ())
    step = searcher.with_weights_of_floors(searcher.step_of(fit, []))
    judge = Judge(step.state, step.state.whitened.chi2, step.screen.typical)
    early = step.state.with_term(Term(Hum, np.array([0.02, 0.85])), most=2)
    first = searcher.refits.newest(judge, early)
    assert "present, negligible" in first.reasons
    decision, found = searcher.refits.converged(judge, (first, early))
    assert decision.drop > 1.5 * first.drop and abs(first.term.size) < 0.05
    assert decision.term.size == pytest.approx(0.1, rel=0.1)
    assert found.fit.terms[-1].values[1] == pytest.approx(0.95, abs=0.01)
    # neither what is accepted nor what is within the scatter is worth the time
    for changes in ({"reasons": ()}, {"p_repeats": 2.0 * first.level}):
        given = (replace(first, **changes), early)
        assert searcher.refits.converged(judge, given) is given
    # what explains less than nothing had not ended, however far from the scatter it seems
    lost = replace(first, drop=-5.0, p_repeats=1.0)
    decision, _ = searcher.refits.converged(judge, (lost, early))
    assert decision.term.size == pytest.approx(0.1, rel=0.1)


def test_a_fault_of_another_form_goes_before_what_imitates_it():
    """The imitation has one size everywhere, and explains half as much."""
    swift = shape("swift", lambda c: (1.0 + 0.5 * c) * wave(10.0))
    like = shape("like", lambda c: bent(c, 10.0) + bent(c, 11.0))
    alone = searched(measured(19, (0.1, like.form)), like, OTHER)
    assert names(alone.last.found) == {"like"}
    search = searched(measured(19, (0.1, lambda c: bent(c, 10.0))), swift, like, OTHER)
    by_name = {d.term.effect.identifier: d for d in search.steps[0].refits}
    assert by_name["like"].accepted and by_name["swift"].misshapen
    assert names(search.last.found) == {"swift"}


def test_a_law_that_explains_nothing_of_consequence_is_not_added():
    law = shape("law", LONG.form, generic=True)
    for size, said, told in ((0.02, AT_FLOOR, set()), (0.03, LAW, {"law"})):
        search = searched(measured(21, (size, LONG.form)), law)
        result = diagnose(search)
        assert result.verdict == said and names(result.found) == names(search.last.found) == told


def test_what_imitates_a_fault_of_another_form_goes_once_the_fault_is_found():
    """Both together explain more than the fault alone, by what its form leaves."""
    swift = shape("swift", lambda c: (1.0 + 0.5 * c) * wave(10.0))
    like = shape("like", lambda c: bent(c, 10.0, 0.5) * (TIME > 2.0))
    hidden = (0.05, lambda c: bent(c, 10.0, 0.5))
    search = searched(measured(19, hidden), swift, like, OTHER)
    by_name = {d.term.effect.identifier: d for d in search.steps[0].refits}
    assert by_name["like"].accepted and by_name["swift"].misshapen
    assert names(search.steps[1].found) == {"like"} and names(search.last.found) == {"swift"}
    both = searched(measured(19, hidden, (0.05, OTHER.form)), swift, like, OTHER)
    assert names(both.last.found) == {"swift", "other"}


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
