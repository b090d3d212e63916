# SPDX-License-Identifier: Apache-2.0
"""The answer of a posterior: named effects with their classes, runners-up, and what is present
without consequence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from flatplank_analysis.discovery.decision import FLAT, NEGLIGIBLE, Decision
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_analysis.inference.posterior import MEMBER, NAMED, Posterior
from flatplank_analysis.inference.weigh import Weighed
from flatplank_data.wording import plain, probability_words, quantity, six_digits

SHOWN = 8
"""most sets and effects that are told"""
INTERVAL = 0.9
"""probability of the interval of a size"""


@dataclass(frozen=True)
class Answer:
    """What a posterior says about the effects of the likeliest set."""

    posterior: Posterior
    named: tuple[AcceptedEffect, ...]
    present: tuple[Term, ...]
    """effects of the likeliest set that are of no consequence"""
    flat: tuple[AcceptedEffect, ...] = ()
    """effects that are sure enough, without which the plain error does not rise"""

    @property
    def terms(self) -> tuple[Term, ...]:
        """Effects of the model that the verdict judges, the named ones last."""
        fitted = self.posterior.best.fit.terms
        return (*self.present, *(fitted[f.decision.place] for f in self.named))


def answer_of(posterior: Posterior, held: int) -> Answer:
    """Name the effects of the likeliest set that are probable enough, alone or as a class.

    held: number of effects, the first ones, that were in the model before the search. An effect
    that is present with a size of no consequence stays in the model; what is neither sure nor
    slight does not, so that the verdict tells what it leaves.
    """
    best = posterior.best
    named, present = [], list(best.fit.terms[:held])
    for index in range(held, len(best.fit.terms)):
        found = _effect(posterior, index)
        if found is not None:
            named.append(found)
        elif posterior.matters(best, index) < NAMED:
            present.append(best.fit.terms[index])
    named.sort(key=lambda f: -f.decision.drop)
    return Answer(posterior, tuple(named), tuple(present))


def _effect(posterior: Posterior, index: int) -> AcceptedEffect | None:
    """An effect of the likeliest set with its class; None when they are not probable enough."""
    best = posterior.best
    rivals = posterior.rivals(best, index)
    probability = probability_of(posterior, index, [r.name for r in rivals if not r.excluded])
    if probability < NAMED:
        return None
    return AcceptedEffect(decision_of(posterior, best, index, probability), rivals)


def probability_of(posterior: Posterior, index: int, others: Sequence[str]) -> float:
    """Probability that an effect of the likeliest set, or one of the others in its place, is
    there; an effect that is sure by itself is as sure beside others of its class."""
    own = {posterior.best.names[index]}
    claims = (own, own.union(others))
    return max(posterior.in_set(names, _rank(posterior, index, names)) for names in claims)


def _rank(posterior: Posterior, index: int, members: set[str]) -> int:
    """Number of effects of a class in the likeliest set that are at least as sure as one of them:
    so many must be there for this one to be."""
    best = posterior.best
    sure = [abs(size) / spread for size, spread in best.sizes]
    own = [i for i, name in enumerate(best.names) if name in members]
    return sum(sure[i] >= sure[index] for i in own)


def decision_of(
    posterior: Posterior, weighed: Weighed, index: int, probability: float, *reasons: str
) -> Decision:
    """The decision about an effect of a set, with the interval of its size there."""
    term = weighed.stated(index)
    size, spread = weighed.sizes[index]
    without = posterior.without(weighed, index)
    wide = spread * float(student.ppf(0.5 + 0.5 * INTERVAL, posterior.freedom))
    null = term.effect.main_parameter().null
    low, high = (null, np.inf) if size > null else (-np.inf, null)
    if probability < NAMED:
        low, high = -np.inf, np.inf
    return Decision(
        term=term,
        drop=posterior.excess(without, weighed) if without else 0.0,
        probability=probability,
        # of what is named on one side of the null: it is there
        interval=(max(size - wide, low), min(size + wide, high)),
        dispersion=posterior.dispersion,
        reasons=reasons,
        place=index,
    )


def doubt_about(posterior: Posterior, weighed: Weighed, index: int, probability: float) -> str:
    """Why an effect of a set that is not probable enough has no name."""
    if posterior.matters(weighed, index) < 0.5:
        return NEGLIGIBLE
    return f"{probability_words(probability)}, below {NAMED:g}"


def present_without_name(answer: Answer, held: int) -> list[Decision]:
    """Effects of the likeliest set that were not named, with the reason."""
    best, out = answer.posterior.best, []
    taken = {f.decision.place for f in answer.named}
    flat = {f.decision.place for f in answer.flat}
    for index in range(held, len(best.fit.terms)):
        term = best.fit.terms[index]
        if index in taken:
            continue
        p = answer.posterior.marginal[term.effect.identifier]
        doubt = doubt_about(answer.posterior, best, index, p)
        reason = FLAT if index in flat else doubt
        out.append(decision_of(answer.posterior, best, index, p, reason))
    return out


def runners_up(answer: Answer) -> Iterator[str]:
    """Effects that are neither named nor improbable, and what speaks against each, in words."""
    named = {n for f in answer.named for n in (f.decision.term.effect.identifier, *f.alike)}
    flat = {f.decision.term.effect.identifier for f in answer.flat}
    for name, p in answer.posterior.marginal.items():
        if name in flat - named:
            there = f"{name}: {probability_words(p)} that it is there"
            yield f"{there}, but {FLAT}, so it is no cause of the error"
        elif name not in named and p > MEMBER:
            why = _against(answer.posterior, name)
            short = f", below {NAMED:g}" if p < NAMED else " in all sets, but not in the likeliest"
            yield f"{name}: {probability_words(p)}{short}: not named; {why}"


def _against(posterior: Posterior, name: str) -> str:
    """What speaks against an effect: in the likeliest set its size, otherwise the odds of the
    likeliest set that has it."""
    best = posterior.best
    inside = [i for i, n in enumerate(best.names) if n == name]
    if inside:
        least = best.fit.terms[inside[0]].effect.main_parameter()
        most = max(posterior.matters(best, i) for i in inside)
        known = max(posterior.known(best, i) for i in inside)
        if known < most:
            return f"it may be scatter or an unknown fault, {probability_words(1.0 - known)}"
        return f"larger than {quantity(least.matters, least.unit)} with {probability_words(most)}"
    other = posterior.sets[next(k for k in posterior.probability if name in k)]
    gain = -0.5 * posterior.excess(other, best)
    price = posterior.fit_and_price(best)[1] - posterior.fit_and_price(other)[1]
    beside = ", ".join(n for n in other.names if n != name)
    where = f"beside {beside}" if beside else "alone"
    balance = f"gains {plain(gain, 2)} by its fit and costs {plain(price, 2)}"
    return f"{where} it {balance} (logarithms of odds)"


def to_dict(posterior: Posterior) -> dict[str, Any]:
    """The posterior for programs: sets and effects with their probabilities, the likeliest first,
    and per set the parts of its evidence against the likeliest one."""
    price = posterior.fit_and_price(posterior.best)[1]
    sets = posterior.sets
    return {
        "nothing": six_digits(posterior.nothing),
        "law_only": six_digits(posterior.law_only),
        "effects": {k: six_digits(p) for k, p in list(posterior.marginal.items())[:SHOWN]},
        "sets": [
            {
                "effects": sets[key].names,
                "probability": six_digits(p),
                "log_odds": six_digits(posterior.logs[key]),
                "fit": six_digits(-0.5 * posterior.excess(sets[key], posterior.best)),
                "price": six_digits(posterior.fit_and_price(sets[key])[1] - price),
                "sizes": [six_digits(size) for size, _ in sets[key].sizes],
            }
            for key, p in list(posterior.probability.items())[:SHOWN]
        ],
    }
