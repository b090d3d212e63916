# SPDX-License-Identifier: Apache-2.0
"""The class of an effect: what may stand in for it, and what takes its place."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from ball import Drag, Shake, Wind, throw
from decisions import decision, odd, rival, screened
from shapes import LONG, OTHER, shape

from flatplank_analysis.discovery import classes, invariants, rivals
from flatplank_analysis.discovery.decision import NEGLIGIBLE, UNEVEN
from flatplank_analysis.discovery.fit import Fitter, Term, Whitened
from flatplank_analysis.discovery.rivals import AlternativeEffect, Rival
from flatplank_analysis.discovery.screen import best_per_effect, screen
from flatplank_analysis.discovery.state import channel_weights, make_state, start_base
from flatplank_analysis.discovery.steps import AcceptedEffect


def test_the_class_of_an_effect():
    others = [rival(f"r{i}", False, False) for i in range(5)]
    found = AcceptedEffect(
        decision(), rivals=(*others, rival("out", True, False), rival("near", True, True))
    )
    assert found.alike == tuple(f"r{i}" for i in range(5))
    assert [r.name for r in found.reported] == ["r0", "r1", "r2", "r3"]
    assert found.excluded_names == ("near",)


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


def test_which_effects_may_explain_the_same(monkeypatch):
    """Those that look like it, whatever they act over, and those over the same coordinate from
    three tenths of its drop on; where several sizes are tried, by the best of them."""
    own = replace(screened(LONG, 1.0), contribution=np.eye(9)[1])

    def asked(effect, gain=301.0, visible=0.5, like=0.0):
        item = screened(effect, 2.0, gain, visible)
        products = np.eye(9)
        products[0, 1] = products[1, 0] = like
        ranking = SimpleNamespace(ranked=[item, own], projected=products)
        return [
            (s.start.effect, s.start.size, s.near)
            for s in rivals.suspects(None, None, ranking, decision(LONG))
        ]

    assert asked(OTHER) == [(OTHER, 0.04, False)] and asked(OTHER, gain=299.0) == []
    assert asked(OTHER, gain=0.0, like=0.81) == [(OTHER, 0.04, True)]
    assert asked(OTHER, gain=0.0, like=0.79) == []
    away = shape("away", OTHER.form, coordinate="angle")
    assert asked(away) == [] and asked(away, like=0.81) == [(away, 0.04, True)]
    # a third of what may be named: the base may take less of it once the effect is gone
    assert asked(OTHER, visible=0.0017) and not asked(OTHER, visible=0.0016)
    assert not asked(shape("free", OTHER.form, generic=True)) and not asked(LONG)
    gap = shape("gap", OTHER.form, starts=classmethod(lambda cls: (1.0, 3.0)))
    best = [(Term(gap, np.array([0.3])), 301.0), (Term(gap, np.array([0.3])), 299.0)]
    monkeypatch.setattr(rivals, "line_search_with_drop", lambda *_: best.pop(0))
    assert asked(gap, gain=0.0) == [(gap, 0.3, False)] and asked(gap, gain=900.0) == []


def test_what_takes_the_place_of_an_effect_is_of_its_class_or_excluded():
    """Refitted with five Jacobians; to the end where it may come as near as three hundredths of
    the drop. No size of no consequence is of the class, and none at an end of its range."""
    first = {"a": 29.0, "b": 31.0, "c": 299.0, "d": 301.0, "small": 5.0, "edge": 6.0, "in": 0.0}
    last = {"b": 7.0, "c": 32.0}
    sizes = {"small": 0.04, "edge": -5.0, "b": -0.06}
    terms = {
        name: Term(shape(name, LONG.form, matters=0.05), np.array([sizes.get(name, 0.06)]))
        for name in first
    }
    fitter = SimpleNamespace(
        without_term=lambda fit, index: (fit, index),
        with_term=lambda less, start: SimpleNamespace(terms=(less, start)),
    )
    asked = []

    def refitted(fit, most=12):
        assert fit.terms[0] == ("whole", 3)
        name = fit.terms[-1].effect.identifier
        asked.append((name, most))
        return Whitened(fit, 1000.0 + (first if most == 5 else last)[name])

    state = SimpleNamespace(
        fit=SimpleNamespace(terms=[terms["in"]]), whitened=Whitened("whole", 1000.0),
        fit_whitened=refitted,
    )  # fmt: skip
    judge = SimpleNamespace(state=state)
    tried = [AlternativeEffect(term, name == "a") for name, term in terms.items()]
    found = rivals.rivals(fitter, judge, 3, decision(drop=1000.0), tried, [])
    told = [(r.name, r.excess, r.near, r.excluded) for r in found]
    assert told == [
        ("small", 5.0, False, True), ("edge", 6.0, False, True), ("b", 7.0, False, False),
        ("a", 29.0, True, False), ("c", 32.0, False, True), ("d", 301.0, False, True),
    ]  # fmt: skip
    assert [name for name, most in asked if most == 12] == ["b", "c"]
    # what all effects explain makes the difference that decides
    others = [decision(drop=1e5)]
    found = rivals.rivals(fitter, judge, 3, decision(drop=1000.0), tried, others)
    assert {r.name for r in found if not r.excluded} == {"a", "b", "c"}
    assert ("b", 12) not in asked[-7:]
    # neither has the form of the fault: one that explains nearly as much stays, unless its own
    # form is much worse
    wrong = decision(drop=1000.0, reasons=UNEVEN[:1], stretch_q=31.0)
    told = {"c": wrong, "d": wrong}
    judge.decide = lambda refit, index, _looked: told[refit.fit.terms[index].effect.identifier]
    last["c"] = 299.0
    found = rivals.rivals(fitter, judge, 3, wrong, tried, [])
    assert {r.name for r in found if not r.excluded} == {"a", "b", "c"}
    told["c"] = decision(reasons=(*UNEVEN, NEGLIGIBLE))
    found = rivals.rivals(fitter, judge, 3, wrong, tried, [])
    assert {r.name for r in found if not r.excluded} == {"a", "b"}


def test_a_rival_that_explains_more_goes_before_an_effect_of_a_wrong_form():
    """By twenty times the scatter; of rivals that differ by less than that the more common one."""

    def rival(rarity, excess, excluded=False):
        term = Term(shape("rival", LONG.form, rarity=rarity), np.array([0.2]))
        return Rival(term, excess, True, excluded)

    rare, usual, common = rival(2, -50.0), rival(1, -31.0), rival(0, -29.0)
    gone = rival(0, -99.0, True)
    every = (gone, rare, usual, common)

    def better(effect, *rivals):
        return classes.better_rival(AcceptedEffect(effect, rivals=rivals))

    assert better(odd(dispersion=1.0), *every) is usual
    assert better(odd(dispersion=0.5), rare) is rare
    assert better(odd(dispersion=2.4), *every) is rare
    assert better(odd(dispersion=2.6), *every) is None
    assert better(odd(dispersion=1.5), usual, common) is usual
    assert better(odd(), gone) is better(odd()) is better(decision(), *every) is None


def test_a_rival_takes_the_place_of_an_effect(monkeypatch):
    """Fitted again from both bases, without raising the error beside the fit without it; the old
    effect may stand in for the new one."""
    best, other = (
        Rival(Term(shape(name, LONG.form), np.array([0.2])), -50.0, True, False)
        for name in ("best", "other")
    )
    suspects = tuple(AlternativeEffect(r.term, False) for r in (best, other))
    kept, old = AcceptedEffect(decision(OTHER)), AcceptedEffect(odd(), suspects)
    less, near = SimpleNamespace(terms="without"), SimpleNamespace(terms="terms", base="near")
    state = SimpleNamespace(
        fit=SimpleNamespace(base="plain"), whitened=SimpleNamespace(fit="white", chi2=500.0),
        fit_whitened=lambda start: {("without", id(best.term)): SimpleNamespace(fit=near)}[start],
    )  # fmt: skip
    fitter = SimpleNamespace(
        without_term=lambda fit, i: {("white", 2): less}[fit, i],
        with_term=lambda fit, term: (fit.terms, id(term)), fit=lambda base, terms: (base, terms),
    )  # fmt: skip
    monkeypatch.setattr(invariants, "not_raising_error", lambda *what: what)
    judged = []

    def rivals(_fitter, judge, index, effect, tried, found):
        judged.append((judge.without, index, effect, tried, found))
        return (best,) if effect.misshapen else ()

    monkeypatch.setattr(classes, "rivals", rivals)
    made = classes.Classes(
        fitter, 1, lambda step: [*step.found, kept],
        lambda fit, found, near: SimpleNamespace(fit=fit, found=found, near=near, **facts),
    )  # fmt: skip
    facts = {"state": state, "screen": SimpleNamespace(typical=None)}
    after = made(SimpleNamespace(found=[kept, old], **facts))
    assert after.fit == (
        fitter, ("plain", "without"), [("plain", "terms"), ("near", "terms")],
    )  # fmt: skip
    assert after.near is near
    first, new, again = after.found
    assert first == again == kept
    assert new.decision == replace(old.decision, term=best.term) and new.rivals == (best,)
    assert new.suspects == (AlternativeEffect(old.decision.term, True), suspects[1])
    both = [kept.decision, old.decision]
    assert judged[:2] == [
        (500.0 + d.drop, i, d, f.suspects, both)
        for i, (d, f) in enumerate(zip(both, (kept, old), strict=True), 1)
    ]
    # the right form stays
    right = SimpleNamespace(found=[kept, kept], **facts)
    assert made(right) is right
