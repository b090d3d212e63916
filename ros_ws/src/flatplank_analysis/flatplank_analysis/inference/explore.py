# SPDX-License-Identifier: Apache-2.0
"""Best-first search over sets of effects, with a joint fit of each set."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.invariants import is_active
from flatplank_analysis.discovery.screen import ScreenResult, best_per_effect
from flatplank_analysis.discovery.starts import start_of
from flatplank_analysis.discovery.state import State, term_with
from flatplank_analysis.inference.evidence import SMALLEST
from flatplank_analysis.inference.posterior import MEMBER, Key, Posterior, log_evidence
from flatplank_analysis.inference.priors import of_set, of_value
from flatplank_analysis.inference.weigh import Scales, Weighed, key_of

CANDIDATES = 8
"""most candidates beside a set that are fitted"""
BEAM = 4
"""most sets of one size from which the search goes on"""
REACH = -math.log(MEMBER)
"""logarithm of the odds against the best set within which a set counts"""
PROMISE = 0.3
"""least linear gain of a candidate, as a share of the largest one: a fit may gain more"""
ROUGH, FAR = 2, 30.0
"""Jacobians of a first fit; logarithm of its odds against the best set within which another one
follows"""
LARGEST = 4
"""most effects in a set"""
ALIKE = 0.8
"""cosine between what two effects of the same parameters do, from which each is tried in the place
of the other"""


@dataclass
class Explorer:
    """All sets that were weighed with the same scales, and which of them were extended."""

    scales: Scales
    sets: dict[Key, Weighed] = field(default_factory=dict)
    extended: set[Key] = field(default_factory=set)
    lessened: set[tuple[Key, int]] = field(default_factory=set)
    """sets that were fitted without one of their effects, and its place"""
    swapped: set[tuple[Key, str]] = field(default_factory=set)
    """sets, each with an effect that was tried in the place of a look-alike"""
    held: int = 0
    """number of effects, the first ones, that are in every set"""
    measured: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """effect -> parameter -> start value"""
    say: Callable[[str], None] = lambda text: None
    """receives what is being done"""

    @property
    def posterior(self) -> Posterior:
        return Posterior(self.sets, self.scales.freedom, self.scales.dispersion)

    def keep(self, weighed: Weighed) -> None:
        """Keep a set; of several fits of one set the likeliest is kept.

        A set with an effect at its null is the set without it; one with an effect that these runs
        cannot tell from the base is none.
        """
        terms, runs = weighed.fit.terms, self.scales.state.runs
        if not all(t.effect.separable(runs, t.named()) for t in terms[self.held :]):
            return
        idle = [i for i in range(self.held, len(terms)) if not is_active(terms[i])]
        if idle:
            if key_of([*terms[: idle[0]], *terms[idle[0] + 1 :]]) not in self.sets:
                self.keep(self._lessened(weighed, idle[0]))
            return
        known = self.sets.get(weighed.key)
        if known is None or known.log < weighed.log:
            self.sets[weighed.key] = weighed

    def _lessened(self, weighed: Weighed, index: int) -> Weighed:
        """The set without one of its effects, fitted from there."""
        return self.scales.fitted(self.scales.fitter.without_term(weighed.fit, index))

    def run(self) -> Posterior:
        """Extend sets until none within reach gains, and no look-alike is left to be tried."""
        while True:
            while (key := self._next()) is not None:
                self.extended.add(key)
                self.say(f"effects beside {', '.join(key) or 'the base'}")
                self.extend(self.sets[key].fit)
            if not self.swap(self.posterior.best):
                return self.posterior

    def swap(self, weighed: Weighed) -> bool:
        """Weigh sets with a look-alike, at the same parameters, in the place of an effect; False
        when all were weighed. From its null the look-alike might end in another minimum."""
        fit, tried = weighed.fit, len(self.swapped)
        for index in range(self.held, len(fit.terms)):
            rest = self.scales.fitter.without_term(fit, index)
            for term in self._look_alikes(fit.terms[index], rest):
                done = weighed.key, f"{index} {term.effect.identifier}"
                if done not in self.swapped:
                    self.swapped.add(done)
                    if self._is_alike(fit, rest, term):
                        self._weigh(rest, term)
        return len(self.swapped) > tried

    def _look_alikes(self, own: Term, rest: Fit) -> Iterator[Term]:
        """Effects with the main parameter of a term, at its parameters, that may be added to the
        rest."""
        beside = [t.effect for t in rest.terms]
        for effect in self.scales.effects:
            full = beside.count(effect) >= effect.instances
            if effect is not own.effect and _main(effect) == _main(own.effect) and not full:
                plain = Term(effect, effect.vector({}), effect.held())
                yield term_with(plain, own.named())

    def _is_alike(self, fit: Fit, rest: Fit, term: Term) -> bool:
        """True when a term changes the rest nearly as what the fit has beyond the rest does."""
        known = rest.parameter_set()
        other = replace(known, effects=(*known.effects, (term.effect, term.values)))
        changed = self.scales.state.model.predict([other])[0]
        pair = np.stack([fit.predicted, changed]) - rest.predicted
        one, two = self.scales.metric_at(fit).plain(pair).reshape(2, -1)
        return float(one @ two) > ALIKE * float(np.linalg.norm(one) * np.linalg.norm(two))

    def extend(self, fit: Fit) -> None:
        """Weigh the sets with one more effect."""
        state, ranking = self.scales.ranked(fit)
        if not ranking.ranked:
            return
        own, best = self.sets[key_of(fit.terms)], self.posterior.best
        lacking = own.parts[0][0] - best.parts[0][0]
        for term in self._promising(state, best_per_effect(ranking), lacking):
            self._weigh(fit, term)

    def _weigh(self, fit: Fit, term: Term) -> None:
        """Weigh a fit with one more effect, the more accurately the more probable the set is."""
        weighed = self.scales.with_term(fit, term, ROUGH)
        self.keep(weighed)
        if self._may_count(weighed, key_of(fit.terms)):
            self.keep(self.scales.fitted(weighed.fit))

    def _may_count(self, weighed: Weighed, without: Key) -> bool:
        """True when a set that is fitted roughly is near the best ones, or has come nearer to the
        best fit than to that without its last effect, or fits worse than without: it is not fitted
        yet."""
        known = self.sets.get(without)
        near = self.posterior.logs.get(weighed.key, -math.inf) > -FAR
        if near or known is None:
            return near
        worse = weighed.parts[known.rank][0] > known.parts[known.rank][0]
        return worse or weighed.log - known.log > self.posterior.best.log - weighed.log

    def _promising(
        self, state: State, items: Sequence[ScreenResult], lacking: float
    ) -> list[Term]:
        """Starts of the candidates that may gain evidence by their linear sums, the best first.

        lacking: decrease of the sum of squares to that of the likeliest set.
        """
        started = [pair for item in items if (pair := self._start(state, item))]
        most = max((gain for _, gain, _ in started), default=0.0)
        least = PROMISE * max(most, lacking)
        likely = []
        for term, gain, volume in started:
            evidence = self._log(most - gain, volume)
            if evidence > self._log(most, 0.0) - REACH and gain > least:
                likely.append((evidence, term))
        likely.sort(key=lambda pair: -pair[0])
        return [term for _, term in likely[:CANDIDATES]]

    def _log(self, excess: float, volume: float) -> float:
        return log_evidence(excess, volume, self.scales.freedom, self.scales.dispersion)

    def _start(self, state: State, item: ScreenResult) -> tuple[Term, float, float] | None:
        """Start of a candidate's fit, its linear gain, and the logarithm of its volume."""
        effect = item.candidate.effect
        start, gain = start_of(state, item, self.measured.get(item.identifier))
        named = start.named()
        if all(named[p.name] == p.null for p in effect.linear()):
            return None
        volume = of_set(1, self.scales.library) - math.log(effect.scanned(state.runs))
        volume += sum(of_value(effect, p, named[p.name]) for p in effect.linear())
        _, size = np.linalg.slogdet(item.information + np.eye(len(item.sizes)) * SMALLEST)
        volume += 0.5 * (len(item.sizes) * math.log(2.0 * math.pi) - float(size))
        return start, gain, volume

    def _next(self) -> Key | None:
        """The next set to extend; None at the end.

        The best set first, then the sets that lack one of its effects (each effect against its
        look-alikes), then the others within reach.
        """
        logs = self.posterior.logs
        best = self.posterior.best
        for key in [best.key, *self._parents(best)]:
            if key not in self.extended and len(key) < self.held + LARGEST:
                return key
        for key in sorted(logs, key=logs.__getitem__, reverse=True):
            full = sum(len(k) == len(key) for k in self.extended) >= BEAM
            open_ = key not in self.extended and len(key) < self.held + LARGEST
            if logs[key] > -REACH and open_ and not full:
                return key
        return None

    def _parents(self, weighed: Weighed) -> Iterator[Key]:
        """Sets that lack one effect of a set, fitted from there as well: the base found with an
        effect may fit better without it than the one found before."""
        terms = weighed.fit.terms
        for index in range(self.held, len(terms)):
            key = key_of([*terms[:index], *terms[index + 1 :]])
            if (weighed.key, index) not in self.lessened:
                self.lessened.add((weighed.key, index))
                self.keep(self._lessened(weighed, index))
            if key in self.sets:
                yield key


def _main(effect: type[Effect]) -> tuple[str, str]:
    """Name and unit of the main parameter of an effect."""
    main = effect.main_parameter()
    return main.name, main.unit
