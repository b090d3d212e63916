# SPDX-License-Identifier: Apache-2.0
"""What is measured next, on states made by hand."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import pytest

from flatplank_analysis.investigation import inquiry
from flatplank_analysis.investigation.planner import (
    DECIDED,
    NOTHING_LEFT,
    SPENT,
    Price,
    Question,
    choose,
)
from flatplank_analysis.investigation.settings import Candidate, Setting, candidates

RUN = Setting(0.05, 1, 1.5, 3700, 2.5)
SIX = [replace(RUN, kappa=k, start=s) for k in (0.02, -0.02, 0.05) for s in (1, 2)]
FAR = Candidate("far step", (replace(RUN, step_position=2.2),))
NEAR = Candidate("once more", (RUN,))
LOADED = Candidate("loaded", (replace(RUN, fz=4800),))


def minutes(**by_text: float):
    """Prices by the text of a candidate."""
    return lambda c: Price(by_text[c.text.replace(" ", "_")], 0)


def question(text: str, needed: float, have: float = 0.0, **gains: float) -> Question:
    return Question(
        text, have, needed,
        lambda settings: next(
            gains.get(c.text.replace(" ", "_"), 0.0)
            for c in (FAR, NEAR, LOADED) if c.settings == settings
        ),
    )  # fmt: skip


def test_most_per_minute_not_most():
    asked = question("to separate a from b", 6.0, far_step=4.0, loaded=5.0)
    cost = minutes(far_step=6.0, loaded=16.0, once_more=6.0)
    choice = choose([asked], [NEAR, LOADED, FAR], cost, 60.0)
    assert (choice.candidate, choice.reason) == (FAR, "to separate a from b")
    assert choice.price.minutes == 6.0
    assert choice.expected == 4.0


def test_more_than_is_asked_is_worth_nothing():
    first = question("to test a", 1.0, far_step=100.0, once_more=2.0)
    other = question("to separate a from b", 6.0, once_more=3.0)
    cost = minutes(far_step=6.0, once_more=6.0, loaded=6.0)
    assert choose([first, other], [FAR, NEAR], cost, 60.0).candidate is NEAR


def test_ties_go_to_fewer_set_up_changes():
    asked = question("to test a", 6.0, far_step=4.0, loaded=4.0)
    prices = {LOADED: Price(6.0, 1), FAR: Price(6.05, 0)}
    for order in ([LOADED, FAR], [FAR, LOADED]):
        assert choose([asked], order, prices.__getitem__, 60.0).candidate is FAR
    prices[FAR] = Price(12.0, 0)  # no tie any more
    assert choose([asked], [FAR, LOADED], prices.__getitem__, 60.0).candidate is LOADED


def test_stop_when_every_question_is_answered():
    done = question("to test a", 3.0, have=3.0, far_step=10.0)
    choice = choose([done], [FAR], minutes(far_step=6.0), 60.0)
    assert (choice.candidate, choice.stop) == (None, DECIDED)


def test_stop_when_no_run_fits_into_what_is_left():
    asked = question("to test a", 3.0, far_step=10.0)
    choice = choose([asked], [FAR], minutes(far_step=6.0), 5.0)
    assert (choice.candidate, choice.stop) == (None, SPENT)


def test_stop_when_what_is_left_cannot_answer():
    asked = question("to test a", 6.0, far_step=0.5, once_more=0.1)
    cost = minutes(far_step=6.0, once_more=6.0)
    assert choose([asked], [FAR, NEAR], cost, 72.0).candidate is FAR
    choice = choose([asked], [FAR, NEAR], cost, 71.0)
    assert (choice.candidate, choice.stop) == (None, NOTHING_LEFT)
    assert choice.reason == "72 minutes would be needed to test a, 71 are left"


def test_what_no_run_tells_does_not_hold_up_what_one_does():
    never = question("to separate a from b", 6.0)
    asked = question("to test a", 3.0, far_step=2.0)
    cost = minutes(far_step=6.0)
    assert choose([never, asked], [FAR], cost, 60.0).candidate is FAR
    choice = choose([never], [FAR], cost, 60.0)
    assert choice.reason == "no run of the bench would help to separate a from b"


def test_candidates_go_round_what_was_made():
    found = candidates(SIX)
    assert all(len({s.condition for s in c.settings}) == 1 for c in found)
    assert len({c.settings for c in found}) == len(found)
    again = [c for c in found if c.text == "slip +2 % once more"]
    assert [c.settings for c in again] == [(replace(RUN, kappa=0.02, start=3),)]
    new = next(c for c in found if c.text == "slip +10 %, a new level")
    assert [(s.kappa, s.start) for s in new.settings] == [(0.1, 1), (0.1, 2)]
    steps = {s.step_position for c in found for s in c.settings}
    assert steps == {0.9, 1.5, 2.2}
    assert {s.fz for c in found for s in c.settings} == {2590, 3700, 4810}


def test_what_was_handed_back_twice_is_not_asked_again():
    third = replace(RUN, kappa=0.02, start=3)
    for times, there in ((1, True), (2, False)):
        found = candidates(SIX, Counter({third: times}))
        assert any(third in c.settings for c in found) is there


def asked_between(monkeypatch, odds: float, each: float):
    """The question about one rival with these odds, of which a run adds so much."""
    rival = SimpleNamespace(name="b", odds=odds)
    found = SimpleNamespace(decision=SimpleNamespace(term=_term("a")), reported=[rival])
    search = SimpleNamespace(
        last=SimpleNamespace(found=[found]), rival_set=lambda _index, _name: None,
        posterior=SimpleNamespace(best=None, dispersion=1.0),
    )  # fmt: skip
    monkeypatch.setattr(inquiry, "Pair", lambda *_: SimpleNamespace(contrast=None))
    monkeypatch.setattr(inquiry, "_gain", lambda _pair, _predictor, _share: lambda _runs: each)
    (question,) = inquiry._between(search, None)
    return question


@pytest.mark.parametrize("odds", [0.9, 0.06, 3.0])
def test_a_class_is_asked_about_as_long_as_the_verdict_names_it(odds, monkeypatch):
    question = asked_between(monkeypatch, odds, 4.0)
    assert question.text == "to separate a from b"
    assert question.needed == pytest.approx(math.log(20.0))
    assert question.open == pytest.approx(min(math.log(20.0) + math.log(odds), math.log(20.0)))
    assert question.gain((RUN,)) == 4.0


def test_a_pair_that_no_run_tells_apart_is_not_pursued(monkeypatch):
    """Ten runs are left: 0.2 each would not do, 2 each would."""
    for each, pursued in ((0.2, False), (2.0, True)):
        asked = asked_between(monkeypatch, 0.5, each)
        choice = choose([asked], [NEAR], minutes(once_more=6.0), 60.0)
        assert (choice.candidate is NEAR) is pursued


def _term(name: str) -> SimpleNamespace:
    return SimpleNamespace(effect=SimpleNamespace(identifier=name))
