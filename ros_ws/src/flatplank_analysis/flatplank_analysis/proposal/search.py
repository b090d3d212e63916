# SPDX-License-Identifier: Apache-2.0
"""From a residual to a proposal: curves at all sites, shapes at the best ones, refits, tests."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.effects.grammar.hooks import HOOKS, Hook
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, effect_of
from flatplank_analysis.effects.grammar.shapes.base import SIGNAL
from flatplank_analysis.inference.beside import Beside
from flatplank_analysis.inference.nextrun import EXCLUDED
from flatplank_analysis.inference.weigh import Weighed
from flatplank_analysis.proposal.scan import (
    CURVE,
    FURTHER,
    SETTING,
    WAVE,
    FittedShape,
    FreeCurve,
    Scanner,
    ScanResult,
    has_period,
)
from flatplank_analysis.proposal.sites import sites_of, varying_coordinates
from flatplank_data.progress import Progress

T = TypeVar("T")
SITES, FORMS, REFITS = 10, 3, 8
"""sites whose shapes are tested; shapes per site, and shapes in total, that are refitted"""
ALIKE_SITES = 3
"""most of these sites with the same hook and modulator"""
WEIGHTS = {CURVE: 2.0, FURTHER: 2.0, WAVE: 1.0, SETTING: 1.0}
"""kind of test -> weight of its share of the test level"""
DOUBT = 2.0
"""penalty for a reason against a site, in parameters"""


@dataclass(frozen=True)
class RefittedSentence:
    """A sentence after its joint refit."""

    sentence: Sentence
    decision: Decision
    weighed: Weighed
    doubt: float
    """what the reasons against its site cost, in logarithms of odds"""

    @property
    def log(self) -> float:
        """Logarithm of its evidence, with what speaks against its site."""
        return self.weighed.log - self.doubt


@dataclass(frozen=True)
class Outcome:
    """Result of a search for a proposal."""

    best: RefittedSentence | None
    tried: tuple[RefittedSentence, ...]
    """all refits, the best first"""
    looked: int
    """number of columns tested at all sites"""
    curve: FreeCurve | None = None
    """the free curve at the best site; None where the form varies faster than the curve"""

    @property
    def confused(self) -> tuple[RefittedSentence, ...]:
        """Sentences that the runs cannot distinguish from the best one: other hooks, coordinates
        or modulators with about the same fit."""
        if self.best is None:
            return ()
        best = self.best
        seen, out = {best.sentence.site.key}, []
        for t in self.tried:
            if t.sentence.site.key not in seen and t.log > best.log + EXCLUDED:
                seen.add(t.sentence.site.key)
                out.append(t)
        return tuple(out)


def bonferroni_divisors(scanned: Sequence[ScanResult]) -> dict[str, float]:
    """Divisor of the family-wise level, for every kind of test (weighted Bonferroni).

    The kinds share the level by their `WEIGHTS`: the few settings of the runs, or a user's column,
    do not pay for all curves along the run, nor anything for the many periods of waves.
    """
    kinds = {s.kind for s in scanned}
    whole = sum(WEIGHTS[kind] for kind in kinds)
    return {
        kind: whole / WEIGHTS[kind] * sum(s.looks for s in scanned if s.kind == kind)
        for kind in kinds
    }


def few_per_hook(best: Sequence[T], site_of: Callable[[T], Site], most: int) -> list[T]:
    """At most `most` items in the same order, and at most ALIKE_SITES of one hook and modulator,
    so that similar coordinates do not fill the list."""
    seen: Counter[tuple[str, str]] = Counter()
    out = []
    for item in best:
        site = site_of(item)
        key = (site.hook.name, site.modulator.name)
        seen[key] += 1
        if seen[key] <= ALIKE_SITES:
            out.append(item)
    return out[:most]


def reasons_against(site: Site) -> int:
    """Number of reasons against a site that the fit does not show.

    A channel measured along the run may itself follow the cause; the pressure acts in the tire; an
    effect that a channel should show, but does not, is unlikely.
    """
    elsewhere = site.coordinate.name == "pressure" and site.hook.kind != "tire"
    return int(site.coordinate.span.kind == SIGNAL) + int(elsewhere) + int(site.hook.shown)


def is_sibling(one: Site, other: Site) -> bool:
    """True for a site with fewer reasons against it that shares hook or coordinate with the other
    one, and differs only in what is doubted."""
    same_hook = one.hook == other.hook
    same_coordinate = other.coordinate.name in (one.coordinate.name, *one.coordinate.alias)
    alike = one.modulator == other.modulator and same_hook != same_coordinate
    return alike and reasons_against(one) < reasons_against(other)


@dataclass
class Proposer:
    """The search from one state of a model."""

    beside: Beside
    """the model"""
    data: TireRuns
    only: Sequence[str] | None = None
    """coordinates that are tested; None: all"""
    hooks: Sequence[Hook] = HOOKS
    progress: Progress | None = None

    def run(self) -> Outcome:
        scanner = Scanner(self.beside.scales.state, self.data)
        coordinates = [
            p for p in varying_coordinates(self.data) if self.only is None or p.name in self.only
        ]
        sites = sites_of(self.data, coordinates, self.hooks)
        scanned = []
        for i, site in enumerate(sites):
            if self.progress is not None and i % 20 == 0:
                self.progress("curves at all sites", 0.5 * i / len(sites))
            scanned += [s for s in (scanner.curve(site), scanner.wave(site)) if s is not None]
        looked = bonferroni_divisors(scanned)
        ranked = self.ranked(scanned)
        best = few_per_hook(ranked, lambda s: s.site, SITES)
        formed: list[tuple[FittedShape, float]] = []
        for s in best:
            self.say("shapes at the best sites", 0.6)
            found = sorted(scanner.forms(s), key=self.negative_evidence)[:FORMS]
            formed += [(f, looked[s.kind]) for f in found]
        formed.sort(key=lambda pair: self.negative_evidence(pair[0]))
        tried = []
        for f, looks in few_per_hook(formed, lambda pair: pair[0].site, REFITS):
            self.say("joint refits", 0.8)
            tried.append(self.refit(f, looks))
        tried += self.refit_siblings(scanner, ranked, tried, looked)
        tried.sort(key=lambda t: -t.log)
        taken = next((t for t in tried if t.decision.accepted), None)
        curve = None
        if taken and not has_period(taken.sentence.shape):
            curve = scanner.free_curve(taken.sentence.site, self.level)
        looked_at = sum(s.looks for s in scanned)
        return Outcome(taken, tuple(tried), looked_at, curve)

    def refit_siblings(
        self, scanner: Scanner, ranked: Sequence[ScanResult], tried: Sequence[RefittedSentence],
        looked: dict[str, float],
    ) -> list[RefittedSentence]:  # fmt: skip
        """Refits of alternatives to the best sentence that have fewer reasons against their site:
        the best form at each sibling site (`is_sibling`) that was not refitted."""
        accepted = [t for t in tried if t.decision.accepted]
        if not accepted:
            return []
        best = max(accepted, key=lambda t: t.log).sentence.site
        seen, out = {t.sentence.site.key for t in tried}, []
        for s in ranked:
            if is_sibling(s.site, best) and s.site.key not in seen:
                self.say("joint refits", 0.9)
                out.append(
                    self.refit(min(scanner.forms(s), key=self.negative_evidence), looked[s.kind])
                )
        return out

    def say(self, text: str, share: float) -> None:
        if self.progress is not None:
            self.progress(text, share)

    @property
    def level(self) -> float:
        """Typical dispersion of the scores in these runs."""
        return max(self.beside.scales.dispersion, 1.0)

    @property
    def price(self) -> float:
        """Penalty per parameter: as in an information criterion for independent samples."""
        state = self.beside.scales.state
        return float(np.log(max(state.floors[0].freedom, state.runs.runs)))

    def ranked(self, scanned: Sequence[ScanResult]) -> list[ScanResult]:
        """Sites by the gain of their curves minus the penalty."""
        worth = [(s.evidence(self.level, self.price), i) for i, s in enumerate(scanned)]
        return [scanned[i] for e, i in sorted(worth, reverse=True) if e > 0.0]

    def negative_evidence(self, formed: FittedShape) -> float:
        return -formed.evidence(self.level, self.price)

    def refit(self, formed: FittedShape, looked: float) -> RefittedSentence:
        """The joint refit of a shape, with all tests."""
        sentence = Sentence(formed.site, formed.shape, formed.numbers)
        effect = effect_of(sentence)
        values = dict(zip(sentence.shape.sizes, map(float, formed.sizes), strict=True))
        values |= formed.numbers
        start = {
            p.name: float(np.clip(values[p.name], p.lower, p.upper)) for p in effect.parameters()
        }
        beside = self.beside.among(looked)
        weighed = beside.with_term(Term(effect, effect.vector(start)))
        decision = beside.decide(weighed)
        named = decision.term.named()
        settled = replace(
            sentence,
            numbers={n.name: named[n.name] for n in formed.shape.numbers},
            sizes=tuple(named[n] for n in sentence.shape.sizes),
            interval=decision.interval,
        )
        return RefittedSentence(settled, decision, weighed, self.doubt(settled.site))

    def doubt(self, site: Site) -> float:
        """What the reasons against a site cost, in logarithms of odds."""
        return 0.5 * DOUBT * self.price * reasons_against(site)
