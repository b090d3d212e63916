# SPDX-License-Identifier: Apache-2.0
"""The rules by which the search chooses, refuses and tells, each on numbers of its own."""

from __future__ import annotations

from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Ball, Drag, Shake, Wind, throw
from scipy.stats import chi2
from shapes import CONDITIONS, LONG, OTHER, REPEATS, measured, shape

from flatplank_analysis.discovery import decide, invariants, rivals, search, shortlist, verdict
from flatplank_analysis.discovery.decide import SHARE, UNEVEN, Decision, Judge
from flatplank_analysis.discovery.effect import Effect, ask, variants_of
from flatplank_analysis.discovery.fit import Fit, Fitter, Term, growth, priors, scale_of
from flatplank_analysis.discovery.model import Form
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.rivals import Rival
from flatplank_analysis.discovery.screen import ScreenResult, best_per_effect, screen
from flatplank_analysis.discovery.state import (
    Candidate,
    channel_weights,
    make_state,
    measured_term,
    start_base,
    stiff_columns,
    term_of,
)
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_data.errors import FlatplankError

RUNS = CONDITIONS * REPEATS


def decision(effect=LONG, size: float = 0.1, **changes) -> Decision:
    """One that every test accepts."""
    facts = dict(
        term=Term(effect, np.array([size])), drop=1000.0, parameters=1, dispersion=1.0,
        dispersion_conditions=1.0, p_repeats=1e-9, p_conditions=1e-9, level=0.01, matters=0.01,
        stretch_q=1.0, stretch_limit=30.0, condition_q=2.0, condition_limit=30.0,
        interval=(0.5 * size, 1.5 * size), held_out_gain=0.5, reasons=(),
    )  # fmt: skip
    return Decision(**{**facts, **changes})


@pytest.mark.parametrize(
    ("changes", "reasons"),
    [
        ({}, ()),
        ({"p_repeats": 0.011}, ("not beyond the scatter among repeats",)),
        ({"p_conditions": 0.0006}, ("not beyond the scatter among conditions",)),
        ({"drop": 0.0}, ("not beyond the scatter among repeats",
                         "not beyond the scatter among conditions")),
        ({"matters": 0.11}, ("present, negligible",)),
        ({"stretch_q": 30.1}, UNEVEN[:1]), ({"condition_q": 30.1}, UNEVEN[1:]),
        ({"interval": (-0.01, 0.2)}, ("its interval covers zero",)),
        ({"term": Term(LONG, np.array([5.0]))}, ("at the end of its physical range",)),
        ({"term": Term(LONG, np.array([-0.1])), "interval": (-0.2, -0.1)}, ()),
    ],
)  # fmt: skip
def test_every_reason_has_its_bound(changes, reasons):
    assert tuple(decide._reasons(decision(**changes))) == reasons


def test_a_free_form_may_have_no_sign():
    free = shape("free", LONG.form, generic=True)
    assert not list(decide._reasons(decision(free, interval=(-0.1, 0.3))))


def test_what_is_explained_already_asks_for_more():
    judge = Judge(None, 0.0, None, explained=1000.0 / SHARE * 1.01)
    assert list(judge._reasons(decision())) == [
        f"its drop is below {100 * SHARE:g} % of what is explained already"
    ]
    judge = Judge(None, 0.0, None, explained=1000.0 / SHARE * 0.99, residue=999.0)
    assert not list(judge._reasons(decision()))
    judge = replace(judge, residue=1001.0)
    assert list(judge._reasons(decision())) == [
        "its drop is below what the wrong form of another effect leaves"
    ]
    judge = replace(judge, residue=0.0, alike={LONG.identifier: 1001.0})
    assert list(judge._reasons(decision())) == [
        "its drop does not distinguish it from a found effect"
    ]


def test_a_fault_of_another_form_leaves_what_differs():
    uneven = decision(reasons=UNEVEN[:1], stretch_q=390.0, condition_q=10.0)
    assert uneven.unevenness == pytest.approx(0.39) and not uneven.accepted
    assert uneven.misshapen and uneven.residue == pytest.approx(390.0)
    assert replace(uneven, condition_q=399.0).residue == pytest.approx(399.0)
    assert not replace(uneven, stretch_q=401.0).misshapen
    assert replace(uneven, stretch_q=401.0).residue == 0.0
    assert not replace(uneven, reasons=(*UNEVEN, "present, negligible")).misshapen
    assert not decision().misshapen and decision().accepted
    free = shape("free", LONG.form, generic=True)
    assert not replace(uneven, term=Term(free, np.array([0.1]))).misshapen
    assert decision(p_conditions=1e-3).p_value == 1e-3 and decision(p_repeats=0.2).p_value == 0.2


def test_an_effect_stays_while_it_explains_something_beside_the_others():
    strong, weak = (
        AcceptedEffect(decision(drop=1e5)),
        AcceptedEffect(decision(drop=1e5 * SHARE * 1.01)),
    )
    assert search._needed(weak, [strong, weak]) and search._needed(strong, [strong, weak])
    weaker = AcceptedEffect(decision(drop=1e5 * SHARE * 0.99))
    assert not search._needed(weaker, [strong, weaker])
    unsure = AcceptedEffect(decision(drop=1e5, p_repeats=0.02))
    assert not search._needed(unsure, [strong, unsure])
    odd = AcceptedEffect(decision(drop=1e5, reasons=UNEVEN[:1], stretch_q=2e3))
    assert not search._needed(AcceptedEffect(decision(drop=1.9e3)), [odd])
    assert search._needed(AcceptedEffect(decision(drop=2.1e3)), [odd])


def test_what_is_good_enough_for_a_full_refit():
    assert search._nearly(decision(reasons=UNEVEN, p_repeats=0.019))
    assert not search._nearly(decision(p_repeats=0.021))
    assert not search._nearly(decision(reasons=("present, negligible",)))
    assert not search._nearly(decision(reasons=("at the end of its physical range",)))


def test_the_largest_gain_comes_first():
    pairs = [(decision(drop=d), None) for d in (3.0, 9.0, 5.0)]
    assert [d.drop for d, _ in search._by_drop(pairs)] == [9.0, 5.0, 3.0]


def test_of_gains_that_cannot_be_told_apart_the_usual_effect_goes_first():
    rare = shape("rare", LONG.form, rarity=1)
    free = shape("free", LONG.form, generic=True)
    preferred = search._Searcher.preferred
    one, other = decision(rare, drop=1000.0), decision(LONG, drop=975.0)
    generic = decision(free, drop=2000.0)
    given = [(d, None) for d in (generic, one, other)]
    assert [d for d, _ in preferred(None, given)] == [other, one, generic]
    far = decision(LONG, drop=960.0)
    assert [d for d, _ in preferred(None, [(one, None), (far, None)])] == [one, far]
    assert not preferred(None, [(decision(p_repeats=0.5), None)])


def test_difference_that_is_no_evidence():
    """Twenty, times the scatter; three hundredths of the drop; what makes an effect at all."""
    assert rivals.indifferent(decision(drop=1.0, dispersion=0.2)) == 20.0
    assert rivals.indifferent(decision(drop=1.0, dispersion=3.0)) == 60.0
    assert rivals.indifferent(decision(drop=1e4)) == pytest.approx(300.0)
    assert rivals.indifferent(decision(drop=1e4), 1e6) == pytest.approx(3000.0)
    uneven = decision(reasons=UNEVEN[:1], drop=1e4, stretch_q=3.9e3)
    assert rivals.indifferent(uneven) == pytest.approx(3.9e3)


def test_what_is_looked_for_at_many_places_pays_for_it():
    places = shape("places", LONG.form, scanned=classmethod(lambda cls, runs: runs.runs))
    found = search.looks([LONG, OTHER, places], measured(0))
    assert found == {"long": 3, "other": 3, "places": 3 * RUNS}


def test_first_weights_are_the_smaller_scatter():
    """Second differences of white noise have six times its variance; a trend has none."""
    ball = measured(3, noise=0.0)
    rng = np.random.default_rng(4)
    values = rng.standard_normal((RUNS, 120)) + 9.0 * np.arange(120)
    ball.runs = replace(ball.runs, measured=values[None])
    (level,) = search._rough_levels(ball)
    assert level == pytest.approx(1.0, rel=0.05)
    spread = values + np.tile([50.0, 0.0, -50.0], CONDITIONS)[:, None]
    ball.runs = replace(ball.runs, measured=spread[None])
    near = np.sqrt(np.mean(np.diff(spread, 2, axis=-1) ** 2) / 6.0)
    assert search._rough_levels(ball) == pytest.approx([4.0 * near])
    ball.runs = ball.runs.subset(np.arange(0, RUNS, REPEATS))
    near = np.sqrt(np.mean(np.diff(ball.runs.measured, 2, axis=-1) ** 2) / 6.0)
    assert search._rough_levels(ball) == pytest.approx([near])


def rival(name: str, excluded: bool, near: bool) -> Rival:
    return Rival(Term(shape(name, LONG.form), np.array([1.0])), 0.0, near, excluded)


def test_the_class_of_an_effect():
    others = [rival(f"r{i}", False, False) for i in range(5)]
    found = AcceptedEffect(
        decision(), rivals=(*others, rival("out", True, False), rival("near", True, True))
    )
    assert found.alike == tuple(f"r{i}" for i in range(5))
    assert [r.name for r in found.reported] == ["r0", "r1", "r2", "r3"]
    assert found.excluded_names == ("near",)


def screened(effect, sizes, gain=1000.0, visible=0.5, setting=None) -> ScreenResult:
    size = np.atleast_1d(np.array(sizes, float))
    candidate = Candidate(effect, setting or {}, np.zeros((len(size), 1, 1, 1)))
    return ScreenResult(candidate, size, gain, visible, np.eye(len(size)), np.eye(9)[0])


def test_what_the_tire_can_feign_is_told_when_the_residual_asks_for_it():
    """Beyond the level and within its range; what is visible, is on the shortlist."""
    looked, typical = {"long": 3, "other": 3}, SimpleNamespace(dispersion=2.0)
    least = 2.0 * 0.8 * chi2.isf(0.05 / 3, 1)

    def told(*items):
        return shortlist.unidentifiable(
            SimpleNamespace(ranked=list(items), typical=typical), looked
        )

    faint = screened(LONG, 1.0, gain=1.01 * least, visible=0.004)
    assert told(faint) == ["long"]
    assert told(screened(OTHER, 1.0, gain=2.0 * least, visible=0.004), faint) == ["other", "long"]
    assert told(screened(LONG, 1.0, gain=0.99 * least, visible=0.004)) == []
    assert told(screened(LONG, 1.0, gain=1.01 * least, visible=0.006)) == []
    far = LONG.main_parameter().upper / LONG.main_parameter().screen
    assert told(screened(LONG, far, gain=2.0 * least, visible=0.004)) == []


def test_the_shortlist_has_what_may_be_an_effect():
    looked = {"long": 3, "other": 3}
    least = 0.8 * chi2.isf(0.05 / 3, 1)
    assert shortlist._least_gain(screened(LONG, 1.0), looked) == pytest.approx(least)
    one, other = screened(LONG, 1.0), screened(OTHER, 1.0, gain=900.0)
    other = replace(other, contribution=np.eye(9)[1])

    def listed(*items, most=5, like=0.0):
        projected = np.eye(9) + like * (np.ones((9, 9)) - np.eye(9))
        result = SimpleNamespace(ranked=list(items), projected=projected)
        return [i.identifier for i in shortlist.shortlist(result, looked, most)]

    assert listed(one, other) == ["long", "other"]
    assert listed(one, other, most=1) == ["long"]
    assert listed(replace(one, gain=0.99 * least), other) == ["other"]
    assert listed(replace(one, visible=0.0049), other) == ["other"]
    # twins take one place: the surer one, or the alphabet
    assert listed(one, other, like=0.999) == ["long"]
    assert listed(replace(other, gain=1010.0), one, like=0.999) == ["long"]
    assert listed(replace(other, gain=1021.0), one, like=0.999) == ["other"]
    assert listed(one, other, like=0.99) == ["long", "other"]
    usual = screened(shape("zzz", LONG.form), 1.0, gain=500.0)
    rare = screened(shape("aaa", LONG.form, rarity=2), 1.0)
    assert shortlist._goes_before(usual, rare) and not shortlist._goes_before(rare, usual)


def test_a_screened_size_far_below_what_matters_is_none():
    """Half of it: the screening is rough. The step is 0.02."""
    least = shape("least", LONG.form, matters=0.1)
    assert shortlist.negligible(screened(least, 2.4))
    assert not shortlist.negligible(screened(least, -2.6))


def test_a_term_starts_at_its_screened_size_within_its_range():
    bounded = shape("bounded", LONG.form, bound=0.05)
    item = screened(bounded, 2.0)
    assert term_of(item.candidate, np.array([2.0])).values == pytest.approx([0.04])
    assert term_of(item.candidate, np.array([-9.0])).values == pytest.approx([-0.05])
    term = term_of(item.candidate, np.array([2.0]))
    assert measured_term(term, {"a": 0.01}).values == pytest.approx([0.01])
    assert measured_term(term, {"a": 0.9}).values == pytest.approx([0.05])
    assert measured_term(term, {}).values == pytest.approx([0.04])


def test_weights_starts_and_stiff_directions_of_a_base():
    ball = throw(1, 0.0)
    assert channel_weights(ball, [0.02, 0.0])[:, 0, 0] == pytest.approx([50.0, 1e12])
    assert start_base(ball).tolist() == [9.0, 0.0]
    assert start_base(ball, {"late": 0.03}).tolist() == [9.0, 0.03]
    fit = Fitter(ball, np.ones((1, 1, 1))).fit(start_base(ball))
    (column,) = stiff_columns(ball, fit)
    # of one unit of `late`, while the fit counts in screening steps of 0.01
    np.testing.assert_allclose(column, fit.jacobian[1] * 100.0)


def test_the_unit_in_which_a_number_is_fitted():
    p = Parameter("p", "1", 3.0, -1.0, 4.0, -0.2)
    assert scale_of(p) == 0.2
    assert scale_of(replace(p, screen=0.0)) == pytest.approx(0.02 * 5.0)
    assert scale_of(replace(p, screen=0.0, upper=np.inf)) == 3.0
    assert scale_of(replace(p, screen=0.0, upper=np.inf, null=0.0)) == 1.0
    entry = SimpleNamespace(parameter=replace(p, prior=0.5), scale=0.2)
    centre, width = priors([entry])
    assert (centre[0], width[0]) == pytest.approx((15.0, 2.5))


class Straight(Ball):
    """The same ball, with a number that is known beforehand to half a thousandth."""

    parameters = (replace(Ball.parameters[0], prior=0.05), Ball.parameters[1])


def test_what_is_known_beforehand_counts_like_a_tenth_of_the_samples():
    ball = Straight(throw(1, 0.0).runs)
    fitter = Fitter(ball, np.full((1, 1, 1), 4.0))
    centre, strength = fitter.centres_and_weights(fitter.entries(()))
    samples = ball.runs.measured[0].size
    assert centre == pytest.approx([90.0, 0.0])
    assert strength == pytest.approx([0.1 * samples * 16.0 / 0.5**2, 0.0])


def test_derivatives_stay_inside_the_ranges():
    ball = throw(2, 0.0)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    top = fitter.fit(np.array([15.0, 0.1]), iterations=0)
    assert set(top.at_bound) == {"g", "late"}
    asked = []
    whole = ball.predict
    ball.predict = lambda sets: asked.extend(one.base for one in sets) or whole(sets)
    columns = fitter.derivative(top).jacobian
    assert np.max(asked, axis=0).tolist() == [15.0, 0.1]
    inner = fitter.fit(np.array([14.999, 0.0999]), iterations=0)
    assert not inner.at_bound
    np.testing.assert_allclose(columns, inner.jacobian, rtol=0.01, atol=1e-3)
    # a tenth of 1 m/s2 more, after two seconds
    assert inner.jacobian[0][0, 0, -1] == pytest.approx(-0.5 * 0.1 * 4.0, rel=0.15)


def test_growth_of_an_effect_by_its_own_size():
    ball = throw(1, 0.0)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    terms = [Term(Drag, np.array([0.03])), Term(Wind, np.array([-0.2]))]
    fit = fitter.fit(start_base(ball), terms, iterations=0)
    assert growth(fit, 0).tolist() == pytest.approx([0.0, 0.0, 3.0, 0.0])
    assert growth(fit, 1).tolist() == pytest.approx([0.0, 0.0, 0.0, -4.0])


def test_limits_of_what_counts():
    """Of the floor and of the form of the model; channels of one unit share the largest force."""
    runs = measured(0, noise=0.0).runs
    values = np.stack([runs.measured[0], -10.0 + 0.0 * runs.measured[0]])
    runs = replace(runs, measured=values, channels=("fx", "fy"), units=("N", "N"))
    form = Form(0.01, 0.02, 0.03, 0.04, side=0.05)
    floors = [SimpleNamespace(floor=2.0), SimpleNamespace(floor=0.1)]
    state = SimpleNamespace(runs=runs, floors=floors, model=SimpleNamespace(form=form))
    assert state.runs.largest == pytest.approx([10.0, 10.0])
    found = invariants.limits(state)
    assert found.rest == pytest.approx(0.6)
    assert found.stretch == pytest.approx(np.hypot(4.0, 0.2))
    assert found.error == pytest.approx(1.1 * np.hypot(2.0, 0.1))
    assert found.bump == pytest.approx(np.hypot(2.0, 0.3))
    assert found.wave == pytest.approx(np.hypot(0.6 * 2.0**0.5, 0.4))
    assert invariants.limits(state, 1).rest == pytest.approx(0.5)
    state.runs = replace(runs, units=("N", "Nm"), input_noise=(1.5, 0.0))
    assert state.runs.largest == pytest.approx([1.0 + 0.1 * 4.0, 10.0])
    error = invariants.limits(state).error
    assert error == pytest.approx(1.1 * np.sqrt(4.0 + 0.014**2 + 1.5**2))


def state_left(varying: float = 0.0, error: float = 0.0, bump: float = 0.0):
    """A state in which nothing is left but this."""
    runs = replace(measured(0).runs, coordinates={})
    level = SimpleNamespace(floor=1.0, unexplained=0.0, p_value=1.0, varying=varying)
    found = SimpleNamespace(size=bump, words=lambda: "a bump")
    return SimpleNamespace(
        runs=runs, floors=[level], model=SimpleNamespace(form=Form()),
        residual=np.full(runs.measured.shape, error),
        patterns=SimpleNamespace(strongest=lambda *_: found if bump else None),
    )  # fmt: skip


def test_what_is_left_is_said_in_words():
    rest = invariants.rest
    assert rest(state_left(), False) == rest(state_left(), True) == ""
    assert rest(state_left(bump=-2.0), False) == "2.0 is left in z: a bump"
    # ordered differences count where nothing is named, the error where something is
    assert "differs between repeats" in rest(state_left(varying=0.6), False)
    assert rest(state_left(varying=0.59), False) == rest(state_left(varying=0.6), True) == ""
    assert "more than 1.1 floors" in rest(state_left(error=1.11), True)
    assert rest(state_left(error=1.09), True) == rest(state_left(error=1.11), False) == ""


def test_a_base_is_far_off_when_it_is_so_everywhere():
    runs = measured(0).runs
    force = np.where(runs.condition == 0, 1.0, 100.0)[:, None] * np.ones(runs.samples)
    runs = replace(runs, measured=np.stack([force, 0.0 * force]), channels=("a", "b"))
    floors = [SimpleNamespace(floor=1.2), SimpleNamespace(floor=1.6)]

    def told(error: float, quiet: float | None = None) -> str:
        residual = np.zeros(runs.measured.shape)
        residual[0] = error
        residual[1, runs.condition == 3] = 2.0 * error
        if quiet is not None:
            residual[:, runs.condition == 5] = quiet
        return invariants.far_off(SimpleNamespace(runs=runs, floors=floors, residual=residual))

    assert told(10.1).endswith(f"of 100 in {runs.condition_names[3]}")
    assert told(10.1).startswith("23 of")
    assert told(9.9) == told(10.1, quiet=3.0) == ""
    # the one that hardly has a force is not asked; five floors of 2 are asked for as well
    floors[0].floor = 3.0
    assert told(10.1) == "" and told(18.0) != ""


def test_a_fit_must_not_raise_the_error():
    ball = throw(1, 0.02)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    old = fitter.fit(start_base(ball))
    assert invariants.error_of(fitter, old) == pytest.approx(
        np.sqrt(np.mean((ball.runs.measured[0] - old.predicted[0]) ** 2))
    )
    good = fitter.fit(old.base, [Term(Drag, np.array([0.01]))])
    bad = fitter.fit(np.array([12.0, 0.0]), [Term(Drag, np.array([0.3]))], iterations=0)
    assert invariants.not_raising_error(fitter, old, [bad, good]) is good
    (term,) = invariants.not_raising_error(fitter, old, [bad]).terms
    assert term.values[0] == pytest.approx(good.terms[0].values[0], rel=0.02)
    null = invariants.at_null(good.terms[0])
    assert invariants.acts(good.terms[0]) and not invariants.acts(null)


def test_settings_that_an_effect_does_not_have_are_refused():
    runs = measured(0).runs

    def of(answer):
        effect = shape("odd", LONG.form, variants=classmethod(lambda cls, r, e: answer))
        return variants_of(effect, runs, runs.measured)

    assert of([{"a": 1.0}]) == [{"a": 1.0}] and of([]) == []
    for answer, words in (
        (None, "no list of settings"), ([1.0], "no list of settings"),
        ([{}, 1.0], "no list of settings"), ([{"a": 1.0}, {"b": 1.0}], "sets 'b'"),
    ):  # fmt: skip
        with pytest.raises(FlatplankError, match=words):
            of(answer)
    with pytest.raises(FlatplankError, match="raised ZeroDivisionError"):
        ask(LONG, lambda: 1 / 0)


def test_an_effect_says_what_it_is_fitted_by():
    more = param(1.0, unit="m", bounds=(0.0, 3.0), matters=0.5, prior=0.1, note="x")
    made = make_dataclass("Both", [("b", float, more)], bases=(LONG,), frozen=True)
    made.main = "b"
    a, b = made.parameters()
    assert (b.null, b.lower, b.upper, b.screen, b.matters, b.prior) == (
        1.0,
        0.0,
        3.0,
        0.0,
        0.5,
        0.1,
    )
    assert made.main_parameter() == b and made.linear() == (a,)
    assert made.null_values().tolist() == [0.0, 1.0] and made.vector({"a": 2.0}).tolist() == [2, 1]
    sets = made.with_values(np.array([[1.0, 2.0], [3.0, 4.0]]), 2)
    assert sets.b.shape == (2, 1, 1) and sets.b.ravel().tolist() == [2.0, 4.0]
    assert made.size({"a": 7.0, "b": 8.0}) == 8.0 and Effect.scanned(None) == 1


def test_runs_means_contrasts_and_some_of_them():
    runs = measured(5).runs.subset(np.array([1, 2, 5, 4, 3, 9]))
    assert runs.names == tuple(f"run {i}" for i in (1, 2, 5, 4, 3, 9))
    assert runs.condition.tolist() == [0, 0, 1, 1, 1, 2] and len(runs.condition_names) == 3
    values = np.arange(6.0)[:, None] * np.ones(runs.samples)
    np.testing.assert_allclose(runs.mean(values)[:, 0], [0.5, 3.0, 5.0])
    np.testing.assert_allclose(runs.contrast(values)[:, 0], [-0.5, 0.5, -1.0, 0.0, 1.0, 0.0])
    assert runs.rmse(values) == pytest.approx(np.sqrt(55.0 / 6.0))
    assert runs.facts["setting"][5] == measured(5).runs.facts["setting"][9]
    assert runs.repeated and len(runs.comparable) == 3
    once = runs.subset([0, 2, 5])
    assert not once.repeated and [len(g) for g in once.comparable] == [3]
    with pytest.raises(FlatplankError, match="channels, runs, samples"):
        replace(runs, measured=runs.measured[0])


def judged(found, left="", lawful=None, unseen=(), monkeypatch=None):
    """The verdict where these effects were found and this is left, before and after polishing."""
    state, polished = SimpleNamespace(floors=[SimpleNamespace(floor=1.0)]), object()
    what = {id(state): left, id(polished): lawful}
    monkeypatch.setattr(invariants, "rest", lambda s, _found: what[id(s)])
    monkeypatch.setattr(verdict, "unidentifiable", lambda _screen, _looked_at: list(unseen))
    steps = SimpleNamespace(state=state, found=found, screen=None)
    search = SimpleNamespace(polished=None if lawful is None else polished, looked_at={})
    return verdict._verdict(search, steps)


def test_verdicts(monkeypatch):
    def told(*given, **more):
        return judged([*given], monkeypatch=monkeypatch, **more)

    one = AcceptedEffect(decision())
    free = AcceptedEffect(decision(shape("free", LONG.form, generic=True)))
    group = replace(one, rivals=tuple(rival(f"r{i}", False, True) for i in range(3)))
    crowd = replace(one, rivals=tuple(rival(f"r{i}", False, True) for i in range(4)))
    assert told()[0] == verdict.AT_FLOOR
    assert told(left="5 N")[0] == verdict.NONE and "5 N" in told(left="5 N")[1]
    assert told(left="5 N", lawful="4 N")[0] == verdict.NONE
    assert told(left="5 N", lawful="")[0] == verdict.LAW
    assert "machine is in order" in told(left="5 N", lawful="")[1]
    assert "machine is in order" not in told(left="5 N", lawful="", unseen=["slow"])[1]
    assert told(free)[0] == told(free, left="5 N", lawful="")[0] == verdict.LAW
    assert told(free, left="5 N")[0] == verdict.PARTLY
    assert told(one, left="5 N") == (verdict.PARTLY, "5 N")
    assert "another form" in told(one, left="5 N", lawful="")[1]
    assert told(one)[0] == told(one, free)[0] == verdict.FOUND
    assert told(one, group)[0] == verdict.GROUP and "cannot be told apart" in told(group)[1]
    assert "more than four" in told(crowd)[1] and "more than four" not in told(group)[1]


def test_what_stands_in_for_an_effect_looks_like_it_or_promises_as_much():
    model = throw(1, 0.02)
    fitter = Fitter(model, channel_weights(model, [0.02]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), [Drag, Wind, Shake])
    ranking = screen(state)
    gains = {i.identifier: i.gain for i in best_per_effect(ranking)}
    of = {}
    for scale in (0.5, 2.0):
        drop = gains["wind"] / 0.3 * scale
        found = rivals.suspects(model, state, ranking, decision(Drag, 0.02, drop=drop))
        of[scale] = {s.start.effect for s in found if not s.near}
    assert Wind in of[0.5] and Wind not in of[2.0]
    assert Drag not in of[0.5]


def test_pieces_of_the_law_are_set_free_together():
    bent = shape("bent", LONG.form, law=True)
    flat = measured(2, (0.2, LONG.form))
    fitter = Fitter(flat, channel_weights(flat, [0.05]))
    state = make_state(flat, fitter, fitter.fit(start_base(flat)), [])
    last = SimpleNamespace(state=state)
    ended = SimpleNamespace(last=last, effects=[OTHER, bent], model=flat)
    free = search.polish(ended)
    assert [t.effect for t in free.fit.terms] == [bent]
    assert free.fit.terms[0].size == pytest.approx(0.2, rel=0.1)
    assert search.polish(SimpleNamespace(last=last, effects=[OTHER], model=flat)) is None
    last.state = free
    assert search.polish(ended) is None


def test_numbers_of_a_fit_belong_to_it():
    fit = Fit(np.zeros(1), (), np.full((1, 2, 3), 4.0), 0.0, np.zeros((3, 1, 2, 3)),
              free=((-1, "a"), (-1, "b"), (0, "c")), known=(1,))  # fmt: skip
    assert fit.loose() == [0, 2]
    np.testing.assert_allclose(fit.residual(np.full((1, 2, 3), 6.0)), 2.0)


def test_the_best_of_several_sizes_with_the_base_moved_along():
    """Drag of two screening steps: of 0.5, 1, 1.5, 2.2 ... the fourth is the nearest."""
    model = throw(1, 0.02)
    fitter = Fitter(model, channel_weights(model, [0.02]))
    state = make_state(model, fitter, fitter.fit(start_base(model)), [Drag])
    (item,) = best_per_effect(screen(state))
    for sizes in (np.zeros(1), np.ones(1)):
        term, gain = shortlist.profile(model, state, replace(item, sizes=sizes))
        assert term.values == pytest.approx([0.022])
        found = state.settle(fitter.grown(state.whitened.fit, term))
        assert gain == pytest.approx(state.whitened.chi2 - found.chi2, rel=0.05)
    half, _ = shortlist.profile(model, state, replace(item, sizes=np.full(1, 0.4)))
    assert half.values == pytest.approx([0.02])
    assert shortlist.line_search(model, state, item).values == pytest.approx(
        shortlist.profile(model, state, item)[0].values
    )
