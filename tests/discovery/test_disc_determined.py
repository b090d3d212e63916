# SPDX-License-Identifier: Apache-2.0
"""Intervals of fitted numbers hold the truth as often as they say; and who determines a number."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, Shake, Wind, throw
from scipy.stats import norm
from shapes import TIME, Sum, measured

from flatplank_analysis.discovery import determined
from flatplank_analysis.discovery.determined import PRIOR, FittedNumber, numbers_of
from flatplank_analysis.discovery.fit import Fitter, Term

TRUTH = {"g": 9.81, "late": 0.01, "k": 0.02}
CAMPAIGNS = 120
DRAG = Term(Drag, np.array([0.01]))


def _numbers(ball, *terms, **how):
    fitter = Fitter(ball, np.ones((1, 1, 1)))
    fit = fitter.fit(np.array([9.0, 0.0, 1.0][: len(ball.parameters)]), terms, **how)
    residual = fit.residual(ball.runs.measured)
    state = SimpleNamespace(fit=fit, runs=ball.runs, fitter=fitter, model=ball, residual=residual)
    return {n.name if n.owner in ("", "drag") else n.owner: n for n in numbers_of(state)}


def test_nine_of_ten_intervals_hold_the_truth():
    """Of a model in noise that is white and drifts: the interval takes it from the repeats."""
    held = dict.fromkeys(TRUTH, 0)
    for seed in range(CAMPAIGNS):
        for name, number in _numbers(throw(1000 + seed, TRUTH["k"]), DRAG).items():
            held[name] += number.interval[0] < TRUTH[name] < number.interval[1]
    # 90 % of 120, and what luck may add or take away in one of a thousand
    assert all(98 <= count <= 118 for count in held.values()), held


def test_the_runs_that_show_a_number_determine_it():
    """Drag shows where the ball is fast: after the throw from the greatest height."""
    number = _numbers(throw(5, TRUTH["k"]), DRAG)["k"]
    assert sum(share for _, share in number.shares) == pytest.approx(1.0)
    assert all(share >= 0.0 for _, share in number.shares)
    assert number.owner == "drag" and number.unit == "1/m" and "m/s" in number.words()


def test_an_end_of_a_range_is_that_of_one_effect():
    """Another effect has a parameter of the same name, inside its range."""
    terms = Term(Wind, np.array([2.0])), Term(Shake, np.array([0.1]))
    numbers = _numbers(throw(5, 0.0), *terms, iterations=0)
    assert (numbers["wind"].name, numbers["wind"].at_bound) == ("a", True)
    assert (numbers["shake"].name, numbers["shake"].at_bound) == ("a", False)


def test_what_no_run_shows_is_known_beforehand_or_not_at_all():
    ball = throw(6, TRUTH["k"])
    spare = type(ball.parameters[0])("spare", "1", 1.0, 0.0, 2.0, 0.1)
    shown = type(ball)(ball.runs)

    def blind(sets):
        return ball.predict([type(one)(one.base[:2], one.effects) for one in sets])

    for prior, words in ((np.inf, "not determined by these runs"), (0.2, f"{PRIOR} 100 %")):
        shown.parameters = (*ball.parameters, replace(spare, prior=prior))
        shown.predict = blind
        number = _numbers(shown)["spare"]
        assert number.words() == words
        reach = number.interval[1] - number.value
        assert reach == (np.inf if prior == np.inf else pytest.approx(norm.ppf(0.95) * prior))


def test_what_determines_a_number_is_told_in_order():
    """Three at most, from a tenth on."""

    def told(*shares: float, end: float = 1.0) -> str:
        listed = tuple(zip("abcde", shares, strict=False))
        return FittedNumber("", "g", "m/s2", 9.0, (9.0 - end, 9.0 + end), listed).words()

    assert told(0.5, 0.31, 0.1, 0.09) == "a 50 %; b 31 %; c 10 %"
    assert told(0.3, 0.3, 0.2, 0.2) == "a 30 %; b 30 %; c 20 %"
    assert told(0.09, 0.09) == "many conditions, a little each"
    assert told(0.5, end=np.inf) == "not determined by these runs"


def test_intervals_of_a_straight_line_by_least_squares():
    """Two channels, the second one with a third of the weight, and a prior of the slope; in the
    units of the parameters."""
    runs = measured(40).runs
    both = np.concatenate([runs.measured, 0.5 + measured(41, noise=0.2).runs.measured])

    class Line(Sum):
        parameters = (Sum.parameters[0], replace(Sum.parameters[1], prior=0.01))

        def predict(self, sets):
            return np.repeat(super().predict(sets)[:, :1], 2, axis=1)

    line = Line(replace(runs, channels=("x", "y"), measured=both))
    weight = np.array([3.0, 1.0])[:, None, None]
    fitter = Fitter(line, weight)
    fit = fitter.fit(np.zeros(2))
    residual = fit.residual(both)
    state = SimpleNamespace(fit=fit, runs=line.runs, fitter=fitter, model=line, residual=residual)
    level, slope = determined.numbers_of(state)
    # in steps of 0.1
    columns = 0.1 * np.stack([np.ones_like(TIME), TIME]) * np.ones((runs.runs, 2, 1))
    _, strength = fitter.centres_and_weights(fitter.entries(()))
    per_run = 10.0 * columns @ np.swapaxes(columns, 1, 2)
    inverse = np.linalg.inv(per_run.sum(axis=0) + np.diag(strength))
    left = 9.0 * residual[0] + residual[1]
    scores = (columns @ left[:, :, None])[:, :, 0]
    for i, number in enumerate((level, slope)):
        parts = np.einsum("j,rjk,k->r", inverse[i], per_run, inverse[i])
        prior = (inverse[i, 1] * strength[1] * 0.1) ** 2
        reach = 0.1 * determined._reach(runs.groups, scores @ inverse[i], parts, prior)
        assert number.value == pytest.approx(fit.base[i])
        assert number.interval == pytest.approx((number.value - reach, number.value + reach))
        by_prior = inverse[i, 1] ** 2 * strength[1]
        assert dict(number.shares)[PRIOR] == pytest.approx(by_prior / (by_prior + parts.sum()))
