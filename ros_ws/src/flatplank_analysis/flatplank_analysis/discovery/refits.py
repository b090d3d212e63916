# SPDX-License-Identifier: Apache-2.0
"""Refits of one effect beside a state, and the order in which they are tried."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.decide import Judge
from flatplank_analysis.discovery.decision import NEGLIGIBLE, Decision
from flatplank_analysis.discovery.fit import ENOUGH, Fitter, Term, Whitened
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.rivals import indecisive_difference
from flatplank_analysis.discovery.screen import VISIBLE, Screen, ScreenResult, best_per_effect
from flatplank_analysis.discovery.shortlist import EVIDENCE, line_search
from flatplank_analysis.discovery.state import (
    State,
    measured_term,
    sized_term,
    start_base,
    term_of,
)

COLD = 2
"""most refits per step that are repeated from the base's start values: the largest drops"""
PROMISING = 0.02
"""p-value among repeats from which on a refit is worth a longer fit"""

Refit = tuple[Decision, Whitened]
"""a whitened fit, and the tests of its last effect"""


@dataclass(frozen=True)
class Refits:
    """Makes and tests refits."""

    model: Model
    fitter: Fitter
    start: Mapping[str, float]
    """start values of base parameters"""
    measured: Mapping[str, Mapping[str, float]]
    """effect -> parameter -> value [SI] measured on the machine, used as start value"""
    looked_at: Mapping[str, int]
    """divisor of the family-wise level, by effect"""

    def newest(self, judge: Judge, found: Whitened) -> Decision:
        """Test the last effect of a fit."""
        terms = found.fit.terms
        return judge.decide(found, len(terms) - 1, self.looked_at[terms[-1].effect.identifier])

    def refit(self, state: State, item: ScreenResult) -> Whitened:
        """Whitened refit from the best of several sizes, the base as it is."""
        start = term_of(item.candidate, item.sizes)
        if len(item.candidate.effect.starts()) > 1:
            start = line_search(self.model, state, item)
        measured = self.measured.get(item.identifier)
        if measured:
            start = measured_term(start, measured)
        return state.with_term(start, most=2)

    def of(
        self, judge: Judge, items: Sequence[ScreenResult]
    ) -> tuple[list[Refit], list[Decision]]:
        """Refits of screened effects by drop, some of them repeated from the start values of the
        base; and the tests of those that do not exceed the scatter (`PROMISING`), whose fits would
        only take memory.

        A refit is repeated when it is among the `COLD` best ones, was refused, and has a larger
        drop than any accepted one.
        """
        out, rest = [], []
        for item in items:
            warm = self.refit(judge.state, item)
            pair = self.converged(judge, (self.newest(judge, warm), warm))
            if pair[0].p_repeats < PROMISING:
                out.append(self.with_known_at_null(judge, pair))
            else:
                rest.append(pair[0])
        out = by_drop(out)
        accepted = max((d.drop for d, _ in out if d.accepted), default=0.0)
        for i, (d, warm) in enumerate(out[:COLD]):
            if d.accepted or d.drop < accepted:
                continue
            cold = self.restarted(judge.state, warm)
            if cold is not warm:
                out[i] = (self.newest(judge, cold), cold)
        return by_drop(out), rest

    def converged(self, judge: Judge, pair: Refit) -> Refit:
        """The refit, continued to its end when it was refused although it exceeds the scatter, or
        when it explains less than nothing: two Jacobians may not reach the size of an effect."""
        d, warm = pair
        slight = d.drop > 0.0 and d.p_repeats > d.level
        if d.accepted or slight or d.term.effect.generic:
            return pair
        found = judge.state.fit_whitened(warm.fit)
        return self.newest(judge, found), found

    def with_known_at_null(self, judge: Judge, pair: Refit) -> Refit:
        """The refit without what `known` parameters have absorbed, where that explains as much.

        They keep the values of the plain fit without the effect, whose size would lack that part.
        """
        d, warm = pair
        start = self.fitter.known_at_null(warm.fit)
        if start is warm.fit or not (d.accepted or d.slight):
            return pair
        found = judge.state.fit_whitened(start)
        return (self.newest(judge, found), found) if found.chi2 < warm.chi2 + ENOUGH else pair

    def restarted(self, state: State, found: Whitened) -> Whitened:
        """The same effects with the base from its start values, when that is better.

        Without the effect the base may have ended at limits where it imitates the effect, which a
        refit from there does not leave. A gap, which may have ended near its null then, is also
        started from its own start size. Free forms of the law are not restarted.
        """
        *others, last = found.fit.terms
        if last.effect.generic:
            return found
        cold = start_base(self.model, self.start)
        sizes = [last, *([_at_start_size(last)] if len(last.effect.starts()) > 1 else [])]
        fits = [state.fit_whitened(self.fitter.fit(cold, [*others, size])) for size in sizes]
        best = min(fits, key=lambda w: w.chi2)
        return best if best.chi2 < found.chi2 - EVIDENCE else found

    def with_start_sizes(
        self, judge: Judge, screen: Screen, items: Sequence[ScreenResult]
    ) -> list[Refit]:
        """Refits of promising effects with several start sizes, from the start values of the base;
        items: those that were refitted already.

        Such an effect is mostly a gap of the machine. Without it the base may have ended at
        parameters that imitate it, where the screening does not show it.
        """
        state, cold = judge.state, start_base(self.model, self.start)
        known = {i.identifier for i in items}
        found = []
        for item in best_per_effect(screen):
            effect = item.candidate.effect
            if len(effect.starts()) < 2 or item.visible < VISIBLE or item.identifier in known:
                continue
            start = term_of(item.candidate, np.full(len(item.sizes), max(effect.starts())))
            fit = self.fitter.fit(cold, [*state.fit.terms, start])
            found.append(state.fit_whitened(fit))
            if len(found) == COLD:
                break
        return by_drop([(self.newest(judge, f), f) for f in found])


def _at_start_size(term: Term) -> Term:
    """The term at the largest start size of its effect; its other parameters stay."""
    effect = term.effect
    return sized_term(effect, term.named(), np.full(len(effect.linear()), max(effect.starts())))


def preferred(tried: list[Refit]) -> list[Refit]:
    """At most three acceptable refits, by gain; free forms of the law come last.

    Where the data do not distinguish the gains, the more common effect (`rarity`) comes first. Of
    equally common ones with nearly the same gain it is the one with fewer parameters.
    """
    good = [pair for pair in tried if nearly(pair[0])]
    named = [p for p in good if not p[0].term.effect.generic]
    if named:
        best = named[0][0]
        near = best.drop - indecisive_difference(best)
        same = best.drop - EVIDENCE * max(best.dispersion, 1.0)

        def order(refit: Refit) -> tuple[float, ...]:
            d = refit[0]
            price = d.parameters if d.drop >= same else math.inf
            return d.drop < near, d.term.effect.rarity, price, -d.drop

        named.sort(key=order)
    free = [p for p in good if p[0].term.effect.generic]
    return (named + free)[:3]


def by_drop(tried: Sequence[Refit]) -> list[Refit]:
    """The largest drop of chi2 first."""
    return sorted(tried, key=lambda pair: -pair[0].drop)


def nearly(decision: Decision) -> bool:
    """True when the first refit is good enough for the full one."""
    hard = {NEGLIGIBLE, "at the end of its physical range"}
    return not hard & set(decision.reasons) and decision.p_repeats < PROMISING
