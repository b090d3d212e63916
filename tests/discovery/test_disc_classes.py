# SPDX-License-Identifier: Apache-2.0
"""What may stand for an effect, from the odds of sets that are given."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from flatplank_analysis.inference.answer import probability_of
from flatplank_analysis.inference.posterior import MEMBER, NAMED, Posterior


def posterior_of(**probabilities: float) -> Posterior:
    """Sets by the letters of their effects; probabilities need not add up to 1."""
    sets = {}
    for letters, p in probabilities.items():
        names = [*letters.replace("_", "")]
        key = tuple(sorted(names))
        surest_last = [(1.0 + i, 1.0) for i in range(len(names))]
        sets[key] = SimpleNamespace(
            names=names, key=key, parts=((0.0, math.log(p)),), sizes=surest_last
        )
    return Posterior(sets, 100.0, 1.0)


def standing_for(posterior: Posterior, effect: str) -> dict[str, tuple[str, float]]:
    """Effect -> letters of the likeliest set, and odds."""
    best = posterior.best
    found = posterior.alternatives(best, len(best.names) - 1 - best.names[::-1].index(effect))
    return {other.names[place]: ("".join(other.names), odds) for other, place, odds in found}


def test_another_effect_stands_for_one_in_all_sets_without_it():
    """Beside another cause of the force the set needs no law of another form; that cause does not
    stand for the law: in the place of the law it is worse than nothing."""
    posterior = posterior_of(plt=0.65, ln=0.25, lnt=0.01, pl=0.05, ltp3=0.03, lpn=0.001, lt=1e-9)
    (name, (likeliest, odds)), *more = standing_for(posterior, "p").items()
    assert (name, likeliest, more) == ("n", "ln", [])
    assert odds == pytest.approx(0.26 / 0.731)
    assert standing_for(posterior, "t") == {} == standing_for(posterior, "l")


def test_what_is_beside_an_effect_does_not_stand_for_it():
    posterior = posterior_of(ab=0.9, a=0.06, b=0.02, bc=0.01, _=0.02)
    assert standing_for(posterior, "a") == {} == standing_for(posterior, "b")


def test_a_second_effect_of_one_name_is_stood_for_by_a_set_with_one():
    posterior = posterior_of(ww=0.6, wr=0.3, w=0.1)
    assert standing_for(posterior, "w") == {"r": ("wr", pytest.approx(0.5))}


def test_an_effect_that_is_sure_by_itself_is_named_beside_one_that_may_stand_for_it(monkeypatch):
    """A second worn patch may stand for the effect, the first one is there or not: one of the two
    kinds twice is less probable than the effect."""
    monkeypatch.setattr(Posterior, "matters", lambda *_: 1.0)
    monkeypatch.setattr(Posterior, "known", lambda *_: 1.0)
    posterior = posterior_of(aw=0.55, a=0.401, ww=0.049)
    assert standing_for(posterior, "a")["w"][1] > MEMBER
    assert posterior.in_set("aw", 2) < 0.6 < NAMED < posterior.marginal["a"]
    assert probability_of(posterior, 0, ["w"]) == pytest.approx(posterior.marginal["a"])


def test_odds_are_finite_however_improbable_a_set_is():
    posterior = posterior_of(a=1.0, b=1e-300)
    weak = posterior.sets[("b",)]
    ((_, _, odds),) = posterior.alternatives(weak, 0)
    assert math.isfinite(odds) and odds > 1e290
