# SPDX-License-Identifier: Apache-2.0
"""Which refit becomes the next step: the first one that passes everything that is asked of it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest
from decisions import decision
from shapes import LONG, OTHER, shape

from flatplank_analysis.discovery import heldout, invariants, search
from flatplank_analysis.discovery.decision import UNEVEN
from flatplank_analysis.discovery.fit import Whitened
from flatplank_analysis.discovery.refits import preferred
from flatplank_analysis.discovery.search import IDLE, _Searcher
from flatplank_analysis.discovery.steps import AcceptedEffect

THIRD = shape("third", LONG.form)
REFUSED = ("its 99 % interval covers zero",)


def fit_of(effect, at_bound=()) -> SimpleNamespace:
    """A whitened fit whose last effect is this one."""
    terms = (SimpleNamespace(effect=effect),)
    return SimpleNamespace(effect=effect, base="white", terms=terms, at_bound=at_bound)


class Told:
    """A search whose parts say what they were asked."""

    known: frozenset = frozenset()
    model, effects = "model", ["effects"]

    def __init__(self, found=(), stands=(), idle=(), bound=(), later=None, left="9 N"):
        """stands: effects that do not stand beside a stronger one; idle: those that backward
        elimination removes; bound: parameters of the base at an end of their range; later:
        decisions at the end of the fit, where they differ from the first ones."""
        self.no_stand, self.idle, self.bound, self.later = stands, idle, bound, later or {}
        self.corrected, self.restarts, self.fits = [], [], []
        self.state = SimpleNamespace(
            fit=SimpleNamespace(base="plain"),
            fit_whitened=lambda fit: Whitened(fit_of(fit.effect, self.bound), 0.0),
        )
        self.step = SimpleNamespace(
            state=self.state, screen="screen", found=list(found), left=left
        )
        self.refits = SimpleNamespace(restarted=self.restarted)
        self.fitter = SimpleNamespace(fit=lambda base, terms: self.fits.append(base) or terms)

    def tested(self, judge, best):
        effect = best.fit.effect
        first = next(d for d in self.step.refits if d.term.effect is effect)
        return f"fair {judge}", self.later.get(effect, first), best

    def correct(self, _step, _tried, now, before):
        self.corrected.append((now[0], before.fit.effect))

    def restarted(self, state, best):
        assert state is self.state
        self.restarts.append(best.fit.effect)
        return best

    def stands_beside_stronger(self, judge, one, tried, misshapen):
        assert judge == "fair judge"
        assert [d for d, _ in tried] == self.given
        return one.term.effect not in self.no_stand

    def step_of(self, fit, found, near):
        return SimpleNamespace(found=found, fit=fit, near=near)

    def backward(self, after):
        after.found = [f for f in after.found if f.decision.term.effect not in self.idle]
        return after

    def take(self, *decisions, chosen=None, misshapen=False):
        """Names of the effects of the next step; chosen: places of those that may be added."""
        self.given, self.step.refits = list(decisions), list(decisions)
        tried = [(d, Whitened(fit_of(d.term.effect), 0.0)) for d in decisions]
        some = preferred(tried) if chosen is None else [tried[i] for i in chosen]
        self.after = _Searcher.take(self, self.step, "judge", tried, some, misshapen)
        return self.after and [f.decision.term.effect.identifier for f in self.after.found]


@pytest.fixture(autouse=True)
def parts(monkeypatch):
    monkeypatch.setattr(
        invariants, "not_raising_error", lambda _fitter, _old, fits: SimpleNamespace(terms=fits[0])
    )
    monkeypatch.setattr(invariants, "is_active", lambda term: term.effect.identifier != "null")
    monkeypatch.setattr(invariants, "is_fall_by_chance", lambda _state, _fit: False)
    monkeypatch.setattr(heldout, "gain", lambda state, fit, index: 0.1 + index)
    monkeypatch.setattr(search, "suspects", lambda *what: what[1:])


def test_the_first_that_passes_is_taken():
    """It is fitted from both bases; its gain where it was not fitted stands with it."""
    told = Told(found=[AcceptedEffect(decision(THIRD))])
    assert told.take(decision(), decision(OTHER, drop=900.0)) == ["third", "long"]
    found = told.after.found[-1]
    assert found.decision == replace(told.step.refits[0], held_out_gain=0.1)
    assert found.suspects == (told.state, "screen", found.decision)
    assert told.fits == ["plain", "white"] and told.after.near.effect is LONG
    assert not told.corrected


def test_the_more_common_of_two_that_cannot_be_told_apart_is_taken():
    rare = shape("rare", LONG.form, rarity=1)
    assert Told().take(decision(rare, drop=1001.0), decision()) == ["long"]


def test_a_chosen_one_is_compared_with_all_others():
    """Only the chosen one was: a conicity of 0.2 %, of a wrong form, was named beside a steering
    zero of no consequence that explained three times as much."""
    told = Told()
    assert told.take(decision(OTHER, drop=9000.0), decision(), chosen=[1]) == ["long"]


@pytest.mark.parametrize(("left", "found"), [("9 N", ["free"]), ("", None)])
def test_a_free_law_is_taken_only_where_something_of_consequence_is_left(left, found):
    """Was taken and searched on beside, and dropped at the end: half of the time with nothing
    hidden, and the way of a false wear."""
    free = shape("free", LONG.form, generic=True)
    assert Told(left=left).take(decision(free)) == found
    assert Told(left=left).take(decision(), decision(free, drop=900.0)) == ["long"]


@pytest.mark.parametrize("refused", [REFUSED, UNEVEN[:1]])
def test_what_is_refused_at_the_end_of_its_fit_is_corrected(refused):
    """The next one is taken; a wrong form passes where it is permitted."""
    last = decision(reasons=refused, stretch_q=200.0)
    told = Told(later={LONG: last}, bound=("g",))
    pair = decision(), decision(OTHER, drop=900.0)
    assert told.take(*pair) == ["other"] and told.corrected == [(last, LONG)]
    assert told.restarts == [OTHER]
    wrong = refused == UNEVEN[:1]
    assert told.take(*pair, misshapen=True) == (["long"] if wrong else ["other"])


def test_a_base_at_an_end_of_its_range_is_started_again_for_the_first_effect():
    for bound, found, wanted in (
        (("g",), [], [LONG]), ((), [], []), (("g",), [AcceptedEffect(decision(THIRD))], []),
    ):  # fmt: skip
        told = Told(found=found, bound=bound)
        assert told.take(decision()) is not None and told.restarts == wanted


def test_what_does_not_stand_beside_a_stronger_one_is_not_taken():
    """Nor what does nothing once the error must not rise."""
    pair = decision(), decision(OTHER, drop=900.0)
    told = Told(stands=(LONG,))
    assert told.take(*pair) == ["other"]
    null = decision(shape("null", LONG.form))
    assert Told().take(null, pair[1]) == ["other"] and Told().take(null) is None


def test_what_goes_again_at_once_is_said_to_be_idle():
    """So is what leads back to the effects of an earlier step."""
    pair = decision(), decision(OTHER, drop=900.0)
    again = Told()
    again.known = {frozenset({"long"}), frozenset()}
    for told in (Told(idle=(LONG,)), again):
        assert told.take(*pair) == ["other"]
        assert [d.reasons for d in told.step.refits] == [(IDLE,), ()]
    assert Told(idle=(LONG,)).take(pair[0]) is None
