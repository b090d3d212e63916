# SPDX-License-Identifier: Apache-2.0
"""Intervals of fitted numbers hold the truth as often as they say; and who determines a number."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ball import Drag, Shake, Wind, throw

from flatplank_analysis.discovery.determined import PRIOR, numbers_of
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

    for prior, words in ((np.inf, "not determined by these runs"), (0.2, f"{PRIOR} 100%")):
        shown.parameters = (*ball.parameters, replace(spare, prior=prior))
        shown.predict = blind
        number = _numbers(shown)["spare"]
        assert number.words() == words
        reach = number.interval[1] - number.value
        assert reach == np.inf if prior == np.inf else 0.3 < reach < 0.4
