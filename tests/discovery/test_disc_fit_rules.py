# SPDX-License-Identifier: Apache-2.0
"""What a fit counts with: weights, units, priors, slopes; and what effects and runs tell it."""

from __future__ import annotations

from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Ball, Drag, Wind, throw
from shapes import LONG, OTHER, TIME, measured, shape

from flatplank_analysis.discovery import fit as fits
from flatplank_analysis.discovery.effect import Effect, call_hook, variants_of
from flatplank_analysis.discovery.fit import (
    Fit,
    Fitter,
    Task,
    Term,
    doubling_step,
    effect_contribution,
    fit_whitened,
    priors,
    scale_of,
)
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.state import (
    channel_weights,
    make_candidates,
    scatter_columns,
    start_base,
)
from flatplank_data.errors import FlatplankError


def test_weights_starts_and_stiff_directions_of_a_base():
    ball = throw(1, 0.0)
    assert channel_weights(ball, [0.02, 0.0])[:, 0, 0] == pytest.approx([50.0, 1e12])
    assert start_base(ball).tolist() == [9.0, 0.0]
    assert start_base(ball, {"late": 0.03}).tolist() == [9.0, 0.03]
    fit = Fitter(ball, np.ones((1, 1, 1))).fit(start_base(ball))
    (column,) = scatter_columns(ball, fit)
    # of one unit of `late`, while the fit counts in screening steps of 0.01
    np.testing.assert_allclose(column, fit.jacobian[1] * 100.0)


def test_the_unit_in_which_a_number_is_fitted():
    p = Parameter("p", "1", 3.0, -1.0, 4.0, -0.2)
    assert scale_of(p) == 0.2
    assert scale_of(replace(p, screen=0.0)) == pytest.approx(0.02 * 5.0)
    assert scale_of(replace(p, screen=0.0, upper=np.inf)) == 3.0
    assert scale_of(replace(p, screen=0.0, lower=-np.inf, null=-3.0)) == 3.0
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


def test_what_is_known_beforehand_pulls_at_a_whitened_fit():
    """g is 9.0 +- 0.05, in steps of 0.1: at 9.2 its weight is 4 and it is pulled by 2 steps."""
    ball = Straight(throw(1, 0.0).runs)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    fit = replace(fitter.fit(start_base(ball), iterations=1), base=np.array([9.2, 0.01]))
    strength, pull = fitter.prior_terms(fit, [1, 0])
    assert strength == pytest.approx([0.0, 4.0]) and pull == pytest.approx([0.0, -8.0])


class Known(Ball):
    """The same ball, with a number that no fit may change to hide an effect."""

    parameters = (replace(Ball.parameters[0], known=True), Ball.parameters[1])


def test_a_whitened_fit_leaves_what_is_known():
    ball = Known(throw(1, 0.0).runs)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    start = fitter.derivative(replace(fitter.fit(start_base(ball)), base=np.array([9.6, 0.0])))
    start = replace(start, predicted=ball.predict([start.parameter_set()])[0])
    found = fit_whitened(lambda values: values, fitter, start)
    assert start.loose() == [1] and found.fit.base[0] == 9.6 and found.fit.base[1] != 0.0
    left = ball.runs.measured - ball.predict([found.fit.parameter_set()])[0]
    assert found.chi2 == pytest.approx(np.sum(left**2))
    assert found.chi2 < np.sum(start.residual(ball.runs.measured) ** 2)


def test_a_whitened_fit_makes_as_many_jacobians_as_it_may(monkeypatch):
    """That of the fit counts as one; known numbers and their priors stay outside."""
    ball = Known(throw(1, 0.0).runs)
    ball.parameters = (ball.parameters[0], replace(ball.parameters[1], prior=0.05))
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    start, asked = fitter.fit(start_base(ball), iterations=1), []

    def ended(problem, z, columns, jacobians):
        asked.append((problem, z, columns, jacobians))
        return SimpleNamespace(point=problem.points([z])[0], columns=columns + 1.0)

    monkeypatch.setattr(fits, "descend", ended)
    for most in (1, 5):
        found = fit_whitened(lambda values: 3.0 * values, fitter, start, most)
        problem, z, columns, jacobians = asked.pop()
        assert jacobians == most - 1 and z == pytest.approx([start.base[1] / 0.01])
        np.testing.assert_allclose(columns, start.jacobian[1:])
        assert (problem.lower, problem.upper) == (pytest.approx([-10.0]), pytest.approx([10.0]))
        assert problem.centre == [0.0] and problem.strength == pytest.approx([0.04])
        assert problem.enough(1e9) == 0.5
        np.testing.assert_allclose(found.fit.jacobian - start.jacobian, [[[[0.0]]], [[[1.0]]]]
                                   + np.zeros_like(start.jacobian))  # fmt: skip
        left = np.sum(start.residual(ball.runs.measured) ** 2)
        assert found.chi2 == pytest.approx(9.0 * left + 0.04 * z[0] ** 2)


def test_a_term_that_goes_takes_its_rows_along():
    ball = throw(1, 0.0)
    fitter = Fitter(ball, np.full((1, 1, 1), 4.0))
    terms = [Term(Drag, np.array([0.03])), Term(Wind, np.array([-0.2]))]
    fit = fitter.fit(start_base(ball), terms, iterations=0)
    for index, rows in ((0, [0, 1, 3]), (1, [0, 1, 2])):
        less = fitter.without_term(fit, index)
        (left,) = less.terms
        assert left.effect is terms[1 - index].effect and less.free[2] == (0, "ak"[index])
        assert left.values == pytest.approx(terms[1 - index].values)
        np.testing.assert_array_equal(less.jacobian, fit.jacobian[rows])
        np.testing.assert_allclose(less.predicted, ball.predict([less.parameter_set()])[0])
    off = replace(fit, predicted=ball.runs.measured - 0.5)
    assert fitter.error(off) == pytest.approx(4.0 * 0.5 * np.sqrt(off.predicted.size))


def test_what_is_fitted_and_how_it_is_packed():
    """Numbers with a step, and those of an effect that are not held; in units of each."""
    held = make_dataclass(
        "held", [(n, float, param(1.0, unit="1", bounds=(0, 2), screen=0.5)) for n in "bc"],
        bases=(Effect,), frozen=True,
    )  # fmt: skip
    ball = throw(1, 0.0)
    ball.parameters = (replace(ball.parameters[0], screen=0.0), ball.parameters[1])
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    terms = [Term(held, np.array([0.5, 1.5]), ("b",)), Term(held, np.array([0.2, 0.8]))]
    task = Task(fitter, np.array([9.5, 0.03]), terms)
    assert task.free == ((-1, "late"), (0, "c"), (1, "b"), (1, "c"))
    z = task.pack(np.array([9.5, 0.03]), terms)
    assert z == pytest.approx([3.0, 3.0, 0.4, 1.6])
    assert task.lower == pytest.approx([-10.0, 0.0, 0.0, 0.0])
    assert task.upper == pytest.approx([10.0, 4.0, 4.0, 4.0])
    base, (one, other) = task.unpack(z + 0.1)
    assert base == pytest.approx([9.5, 0.031]) and one.fixed == ("b",)
    assert one.values == pytest.approx([0.5, 1.55]) and other.values == pytest.approx([0.25, 0.85])


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


def test_directions_of_the_scatter_are_sums_over_the_numbers_that_are_fitted():
    """In units of each number; what is not fitted does not scatter, nor does an effect whose
    number has the same name."""
    g, late = replace(Ball.parameters[0], screen=-0.1), Ball.parameters[1]
    model = SimpleNamespace(
        parameters=(g, late, replace(g, name="fixed", screen=0.0)),
        scatter_directions=lambda base: ({"g": 0.5, "late": -0.02, "fixed": base[2]}, {"g": 1.0}),
    )
    jacobian = np.random.default_rng(1).standard_normal((3, 1, 4, 5))
    free = ((-1, "g"), (-1, "late"), (0, "g"))
    fit = Fit(np.ones(3), (), np.zeros((1, 4, 5)), 0.0, jacobian, free)
    both, one = scatter_columns(model, fit)
    np.testing.assert_allclose(both, 5.0 * jacobian[0] - 2.0 * jacobian[1])
    np.testing.assert_allclose(one, 10.0 * jacobian[0])
    model.scatter_directions = lambda base: ()
    assert scatter_columns(model, fit).shape == (0, 1, 4, 5)


def test_columns_of_effects_that_may_be_added():
    """By one screening step in every setting, beside what is in the model; an effect goes in as
    often as it may, and only where the runs can tell it from the base."""
    model = measured(0)
    fitter = Fitter(model, np.ones((1, 1, 1)))
    terms = [Term(OTHER, np.array([0.3])), Term(LONG, np.array([0.2]))]
    fit = fitter.fit(start_base(model), terms, iterations=0)
    twice = shape("twice", OTHER.form, instances=2)
    settings = classmethod(lambda cls, runs, residual: [{"at": 1.0}, {"at": residual.max()}])
    place = param(0.0, unit="m", bounds=(-9.0, 9.0))
    moved = make_dataclass("moved", [("at", float, place)], bases=(LONG,), frozen=True)
    moved.variants, moved.form = settings, staticmethod(lambda c: 3.0 * LONG.form(c))
    hidden = shape("hidden", LONG.form, separable=classmethod(lambda cls, runs: False))

    def made(*effects, beside=fit):
        found = make_candidates(model, beside, effects, np.full((1, 1, 1), 2.0))
        return [(c.effect, c.setting, c.columns) for c in found]

    assert made(OTHER, hidden, LONG) == [] and made() == []
    (one, setting, columns), *others = made(twice, moved)
    assert (one, setting, len(others)) == (twice, {}, 2)
    np.testing.assert_allclose(columns[0, 0], 0.02 * OTHER.form(model.setting), atol=1e-12)
    for (effect, setting, columns), at in zip(others, (1.0, 2.0), strict=True):
        assert effect is moved and setting == {"at": at}
        np.testing.assert_allclose(columns[0, 0], 0.06 * LONG.form(model.setting), atol=1e-12)
    again = replace(fit, terms=(*fit.terms, Term(twice, np.array([0.1]))))
    assert [effect for effect, *_ in made(twice, beside=again)] == [twice]
    again = replace(again, terms=(*again.terms, again.terms[-1]))
    assert made(twice, beside=again) == []
    endless = shape("endless", lambda c: np.inf * np.ones_like(c * TIME))
    with pytest.raises(FlatplankError, match=r"effect endless.*NaN or infinity|NaN or inf"):
        made(endless)


def test_a_number_ends_a_millionth_of_its_unit_before_its_range():
    ball = throw(1, 0.0)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    for away, bound in ((0.9e-8, ("late",)), (1.1e-8, ()), (1e-6, ())):
        fit = fitter.fit(np.array([9.0, 0.1 - away]), iterations=0)
        assert fit.at_bound == bound


def test_a_plain_fit_does_not_depend_on_the_unit_of_the_error():
    ball, ends = throw(1, 0.0), []
    for unit in (1.0, 1e-3, 1e3):
        fit = Fitter(ball, np.full((1, 1, 1), unit)).fit(np.array([14.0, -0.09]))
        assert fit.chi2 == pytest.approx(unit**2 * np.sum(fit.residual(ball.runs.measured) ** 2))
        ends.append(fit.base)
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=1e-9)


def test_growth_of_an_effect_by_its_own_size():
    ball = throw(1, 0.0)
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    terms = [Term(Drag, np.array([0.03])), Term(Wind, np.array([-0.2]))]
    fit = fitter.fit(start_base(ball), terms, iterations=0)
    assert doubling_step(fit, 0).tolist() == pytest.approx([0.0, 0.0, 3.0, 0.0])
    assert doubling_step(fit, 1).tolist() == pytest.approx([0.0, 0.0, 0.0, -4.0])
    np.testing.assert_allclose(effect_contribution(fit, 0), 3.0 * fit.jacobian[2])
    # its size counts from the null, and what is no size of it does not grow
    size, place = (
        param(1.0, unit="1", bounds=(0, 9), screen=0.5), param(2.0, unit="m", bounds=(0, 9)),
    )  # fmt: skip
    from_one = make_dataclass(
        "from_one", [("a", float, size), ("at", float, place)], bases=(Effect,), frozen=True
    )
    free = ((-1, "g"), (0, "a"), (0, "at"), (1, "a"), (1, "at"))
    terms = tuple(Term(from_one, np.array(v)) for v in ((3.0, 4.0), (0.5, 6.0)))
    fit = replace(fit, terms=terms, free=free)
    assert doubling_step(fit, 0).tolist() == [0.0, 4.0, 0.0, 0.0, 0.0]
    assert doubling_step(fit, 1).tolist() == [0.0, 0.0, 0.0, -1.0, 0.0]


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
        call_hook(LONG, lambda: 1 / 0)


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
    # one refit, from the screened size
    assert made.starts() == (1.0,) and made.held() == () and made.variants(None, None) == [{}]


def test_runs_means_contrasts_and_some_of_them():
    runs = measured(5).runs.subset(np.array([1, 2, 5, 4, 3, 9]))
    assert runs.names == tuple(f"run {i}" for i in (1, 2, 5, 4, 3, 9))
    assert runs.condition.tolist() == [0, 0, 1, 1, 1, 2] and len(runs.condition_names) == 3
    values = np.arange(6.0)[:, None] * np.ones(runs.samples)
    np.testing.assert_allclose(runs.mean(values)[:, 0], [0.5, 3.0, 5.0])
    np.testing.assert_allclose(runs.contrast(values)[:, 0], [-0.5, 0.5, -1.0, 0.0, 1.0, 0.0])
    assert runs.rmse(values) == pytest.approx(np.sqrt(55.0 / 6.0))
    # one of two repeats, one of three, and one alone
    for run, largest in ((0, 15.0), (3, 10.0), (5, 30.0)):
        spike = np.zeros(runs.measured.shape)
        spike[0, run, 7] = -30.0
        assert replace(runs, measured=spike).largest == pytest.approx([largest])
    assert runs.facts["setting"][5] == measured(5).runs.facts["setting"][9]
    assert runs.repeated and len(runs.comparable) == 3
    once = runs.subset([0, 2, 5])
    assert not once.repeated and [len(g) for g in once.comparable] == [3]
    with pytest.raises(FlatplankError, match="channels, runs, samples"):
        replace(runs, measured=runs.measured[0])
    for wrong in ({"channels": ("x", "y")}, {"names": runs.names[1:]}):
        with pytest.raises(FlatplankError, match="measured has shape"):
            replace(runs, **wrong)
    twice = runs.subset([0, 1, 2])
    assert twice.repeated and [len(g) for g in twice.groups] == [2, 1]


def test_numbers_of_a_fit_belong_to_it():
    fit = Fit(np.zeros(1), (), np.full((1, 2, 3), 4.0), 0.0, np.zeros((3, 1, 2, 3)),
              free=((-1, "a"), (-1, "b"), (0, "c")), known=(1,))  # fmt: skip
    assert fit.loose() == [0, 2]
    np.testing.assert_allclose(fit.residual(np.full((1, 2, 3), 6.0)), 2.0)


@pytest.mark.parametrize(
    ("null", "value", "at_end"),
    [(1.0, 0.005, True), (1.0, 3.995, True), (1.0, 0.02, False), (0.0, 0.0, False),
     (0.0, 4.0, True), (4.0, 4.0, False), (4.0, 0.0, True)],
)  # fmt: skip
def test_the_end_of_a_range_that_is_no_effect_is_no_limit(null, value, at_end):
    assert Parameter("a", "1", null, 0.0, 4.0, 0.1).at_end(value, 0.01) == at_end
