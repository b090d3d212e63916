# SPDX-License-Identifier: Apache-2.0
"""What a fit counts with: weights, units, priors, slopes; and what effects and runs tell it."""

from __future__ import annotations

from dataclasses import make_dataclass, replace

import numpy as np
import pytest
from ball import Ball, Drag, Wind, throw
from shapes import LONG, measured, shape

from flatplank_analysis.discovery.effect import Effect, call_hook, variants_of
from flatplank_analysis.discovery.fit import (
    Fitter,
    Term,
    doubling_step,
    effect_contribution,
    fit_whitened,
)
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.state import (
    start_base,
)
from flatplank_data.errors import FlatplankError


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
    assert made.vector({}).tolist() == [0.0, 1.0] and made.vector({"a": 2.0}).tolist() == [2, 1]
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
