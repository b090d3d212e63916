# SPDX-License-Identifier: Apache-2.0
"""Forward search with real refits, backward elimination after each step (DISCOVERY 10)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import chi2

from flatplank_analysis.discovery import decide as decisions
from flatplank_analysis.discovery import screen as screens
from flatplank_analysis.discovery.decide import Decision
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Fitter, Term
from flatplank_analysis.discovery.model import Lane, Model
from flatplank_analysis.discovery.screen import Screen, Screened
from flatplank_analysis.discovery.state import (
    State,
    channel_weights,
    make_state,
    measured_term,
    start_base,
    term_of,
)
from flatplank_analysis.errors import FlatplankError

NEARLY_ALIKE = 0.8
TWINS = 0.995
HOPE = 0.8
"""a refit may bring that much more than the screening promised"""
ALIKE = 0.03
"""share of a drop that is no evidence between two effects: the law of the model is no better"""
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Found:
    """An effect that was accepted."""

    decision: Decision
    alike: tuple[str, ...]
    """cannot be told apart from it with these runs"""
    weakly: tuple[str, ...]
    """can hardly be told apart"""


@dataclass
class Step:
    """The state of the search after a number of accepted effects."""

    state: State
    screen: Screen
    found: list[Found]
    refits: list[Decision] = field(default_factory=list)
    """what was tried from here, best first"""


@dataclass
class Search:
    """All steps of a search; the last one is the result."""

    model: Model
    effects: list[type[Effect]]
    steps: list[Step]
    seconds: float
    looked_at: dict[str, int]
    """by effect: in how many ways it was looked for, times the number of effects"""
    first_ranking: float
    """seconds until the first ranking was there"""
    polished: State | None = None
    """the end of the search with all pieces of the law set free: what they take is no fault"""

    @property
    def last(self) -> Step:
        """Where the search ended."""
        return self.steps[-1]


@dataclass
class Options:
    """How far the search goes."""

    most: int = 4
    """effects at most"""
    refits: int = 5
    """candidates that are refitted per step"""
    progress: Progress | None = None
    start: dict[str, float] = field(default_factory=dict)
    """start values of base parameters"""
    terms: tuple[Term, ...] = ()
    """effects that are in the model already"""
    measured: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """effect -> parameter -> value [SI] that was measured at the machine: where its fit starts"""


def run_search(
    model: Model, effects: Sequence[type[Effect]], options: Options | None = None
) -> Search:
    """Search for the effects that a model lacks."""
    options = options or Options()
    if not model.runs.repeated:
        raise FlatplankError("no repeats", "campaign", "repeat at least one condition")
    return _Searcher(model, list(effects), options).run()


def looks(effects: Sequence[type[Effect]], model: Model) -> dict[str, int]:
    """By effect the number by which the family-wise level is divided (weighted Bonferroni).

    Every effect gets the same share; one that is looked for at many places, or at many periods,
    pays for its own looking and not the others with it.
    """
    return {
        e.identifier: len(effects) * max(len(e.linear()), 1) * e.scanned(model.runs)
        for e in effects
    }


def polish(search: Search) -> State | None:
    """Set free every piece of the law; None when there is none."""
    last = search.last.state
    present = {t.effect for t in last.fit.terms}
    pieces = [e for e in search.effects if e.law and e not in present]
    if not pieces:
        return None
    terms = [
        Term(e, e.vector(e.variants(search.model.runs, last.residual)[0]), e.held())
        for e in pieces
    ]
    weight = channel_weights(search.model.runs, [f.floor for f in last.floors])
    fitter = Fitter(search.model, weight)
    fit = fitter.fit(last.fit.base, [*last.fit.terms, *terms], iterations=10)
    return make_state(search.model, fitter, fit, [])


class _Searcher:
    def __init__(self, model: Model, effects: list[type[Effect]], options: Options) -> None:
        self.model, self.effects, self.options = model, effects, options
        self.began = time.perf_counter()
        self.fitter = Fitter(model, channel_weights(model.runs, _rough_levels(model)))
        self.looked_at = looks(effects, model)

    def say(self, text: str, share: float) -> None:
        if self.options.progress is not None:
            self.options.progress(text, share)

    def run(self) -> Search:
        self.say("fit of the base", 0.0)
        fit = self.first_fit()
        step = self.step_of(fit, [], update=True)
        first = time.perf_counter() - self.began
        steps = [step]
        for number in range(self.options.most):
            self.say(f"refits, step {number + 1}", 0.2 + 0.15 * number)
            after = self.forward(step)
            if after is None:
                break
            step = self.backward(after)
            steps.append(step)
        seconds = time.perf_counter() - self.began
        return Search(self.model, self.effects, steps, seconds, self.looked_at, first)

    def first_fit(self) -> Fit:
        base = start_base(self.model, self.options.start)
        fit = self.fitter.fit(base, self.options.terms)
        return fit

    def step_of(self, fit: Fit, found: list[Found], update: bool = False) -> Step:
        """State and ranking; `update` takes the floor into the weights once."""
        self.say("screening", 0.15)
        state = make_state(self.model, self.fitter, fit, self.effects)
        if update:
            levels = [f.floor for f in state.floors]
            self.fitter = Fitter(self.model, channel_weights(self.model.runs, levels))
        ranking = screens.screen(state)
        return Step(state, ranking, found)

    def forward(self, step: Step) -> Step | None:
        """Refit the best candidates; the best one that passes all tests is taken."""
        state = step.state
        without = decisions.best_chi2(state, state.fit)
        explained = sum(f.decision.drop for f in step.found)
        tried: list[tuple[Decision, Fit]] = []
        for item in self.worth_a_refit(step):
            fit = self.refit(state, item)
            index = len(fit.terms) - 1
            looked = self.looked_at[item.identifier]
            decision = decisions.decide(state, without, fit, index, looked, explained)
            tried.append((decision, fit))
        tried.sort(key=lambda pair: -pair[0].drop)
        step.refits = [d for d, _ in tried]
        for _, rough in self.preferred(tried, step):
            fit = self.fitter.fit(rough.base, rough.terms)
            index = len(fit.terms) - 1
            looked = self.looked_at[fit.terms[index].effect.identifier]
            decision = decisions.decide(state, without, fit, index, looked, explained)
            if not decision.accepted:
                continue
            found = Found(decision, *self.alike(step, decision))
            return self.step_of(fit, [*step.found, found])
        return None

    def worth_a_refit(self, step: Step) -> list[Screened]:
        """Candidates with a gain, visible, and of a size that may matter; best first."""
        out: list[Screened] = []
        for item in screens.best_per_effect(step.screen):
            effect = item.candidate.effect
            if item.gain < self.least_gain(item) or item.visible < screens.VISIBLE:
                continue
            if len(effect.starts()) == 1 and negligible(item):
                continue
            twin = next((i for i, o in enumerate(out) if _twins(step.screen, item, o)), None)
            if twin is not None:
                # the same in these data: what is more usual, then the alphabet, not the order
                # of the noise
                out[twin] = min(out[twin], item, key=_usual)
                continue
            out.append(item)
            if len(out) == self.options.refits:
                break
        return out

    def least_gain(self, item: Screened) -> float:
        """Gain below which no refit is likely to pass the test of the effect."""
        level = decisions.FAMILY / self.looked_at[item.identifier]
        return HOPE * float(chi2.isf(level, len(item.sizes)))

    def refit(self, state: State, item: Screened) -> Fit:
        """Refit from the best of several sizes, the base as it is."""
        own = state.fit
        starts = [term_of(item.candidate, item.sizes * s) for s in item.candidate.effect.starts()]
        if len(starts) > 1:
            starts = [line_search(self.model, state, item)]
        measured = self.options.measured.get(item.identifier)
        if measured:
            starts = [measured_term(starts[0], measured)]
        # a law moves the whole base along: the old derivatives serve for the machine only
        quick = item.candidate.effect.kind != "tire" or item.candidate.effect.generic
        return self.fitter.fit(own.base, [*own.terms, starts[0]], known=own, quick=quick)

    def preferred(
        self, tried: list[tuple[Decision, Fit]], step: Step
    ) -> list[tuple[Decision, Fit]]:
        """Acceptable refits by gain; a free law only when no named effect is acceptable.

        Of refits whose gains the data cannot tell apart the more usual effect goes first.
        """
        good = [pair for pair in tried if _nearly(pair[0])]
        named = [p for p in good if not p[0].term.effect.generic]
        if named:
            best = named[0][0]
            near = best.drop - _indifferent(best)
            named.sort(key=lambda p: (p[0].drop < near, p[0].term.effect.rarity, -p[0].drop))
        free = [p for p in good if p[0].term.effect.generic]
        return (named + free)[:3]

    def alike(self, step: Step, decision: Decision) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names that look like the effect, once the model has taken its part.

        Two effects are told apart when the one leaves of the other's drop more than the
        dispersion can account for, and more than the form of the model's law may be wrong by.
        """
        mine = screens.settings_of(step.screen, decision.term.effect.identifier)
        same: list[str] = []
        weak: list[str] = []
        if not mine:
            return (), ()
        drop = max(decision.drop, 1e-9)
        for other in screens.best_per_effect(step.screen):
            if other.identifier == mine[0].identifier or other.visible < screens.VISIBLE / 3:
                continue
            if other.candidate.effect.generic:
                continue
            rho = min(
                screens.likeness(step.screen, mine[0], other),
                screens.likeness(step.screen, other, mine[0]),
            )
            left = drop * (1.0 - rho**2)
            if rho > NEARLY_ALIKE and left < _indifferent(decision):
                same.append(other.identifier)
            elif rho > NEARLY_ALIKE:
                weak.append(other.identifier)
        return tuple(same), tuple(weak)

    def backward(self, step: Step) -> Step:
        """Drop accepted effects that are not needed any more; refresh the tests of the others."""
        if len(step.found) < 2:
            return step
        fit, state = step.state.fit, step.state
        kept, offset = [], len(self.options.terms)
        for i, found in enumerate(step.found):
            index = offset + i
            others = [t for j, t in enumerate(fit.terms) if j != index]
            less = self.fitter.fit(fit.base, others, quick=True)
            less = self.fitter.derivative(less)
            without = decisions.best_chi2(state, less)
            looked = self.looked_at[fit.terms[index].effect.identifier]
            decision = decisions.decide(state, without, fit, index, looked)
            if decision.drop > 0.0 and decision.p_repeats < decision.level:
                kept.append((i, Found(decision, found.alike, found.weakly)))
        if len(kept) == len(step.found):
            step.found = [f for _, f in kept]
            return step
        rows = list(range(offset)) + [offset + i for i, _ in kept]
        smaller = self.fitter.fit(fit.base, [fit.terms[j] for j in rows])
        return self.step_of(smaller, [f for _, f in kept])


def line_search(model: Model, state: State, item: Screened) -> Term:
    """Size with the smallest plain sum of squares once the base has moved along."""
    effect, fit = item.candidate.effect, state.fit
    width = item.sizes if np.any(item.sizes) else np.ones_like(item.sizes)
    terms = [term_of(item.candidate, width * s) for s in (0.5, 1.0, 1.5, 2.2, 3.3, 5.0)]
    terms += [term_of(item.candidate, np.ones_like(width) * s) for s in (1.0, 3.0)]
    own = fit.lane()
    lanes = [Lane(own.base, (*own.effects, (effect, t.values))) for t in terms]
    change = model.predict(lanes) - fit.predicted
    weight = 1.0 / np.array([max(f.floor, 1e-12) for f in state.floors])[:, None, None]
    flat = (state.jacobian * weight).reshape(len(state.jacobian), -1)
    gram = flat @ flat.T
    gram += 1e-8 * np.trace(gram) * np.eye(len(gram))
    errors = []
    for c in change:
        e = ((state.residual - c) * weight).reshape(-1)
        right = flat @ e
        errors.append(float(e @ e - right @ np.linalg.solve(gram, right)))
    return terms[int(np.argmin(errors))]


def _indifferent(decision: Decision) -> float:
    """Difference of gains that is no evidence between two effects."""
    return max(20.0 * max(decision.dispersion, 1.0), ALIKE * decision.drop)


def _nearly(decision: Decision) -> bool:
    """Good enough after the quick refit to deserve the full one."""
    hard = {"present, negligible", "at the end of its physical range"}
    return not hard & set(decision.reasons) and decision.p_repeats < 0.02


def _twins(ranking: Screen, one: Screened, other: Screened) -> bool:
    """True when the model cannot but take one for the other."""
    return (
        screens.likeness(ranking, one, other) > TWINS
        and screens.likeness(ranking, other, one) > TWINS
    )


def _usual(item: Screened) -> tuple[int, str]:
    return item.candidate.effect.rarity, item.identifier


def negligible(item: Screened) -> bool:
    """True when the screened size is far below the one that matters."""
    effect = item.candidate.effect
    matters = effect.main_parameter().matters
    named = {
        p.name: p.null + p.screen * s for p, s in zip(effect.linear(), item.sizes, strict=True)
    }
    values = {p.name: p.null for p in effect.parameters()} | item.candidate.setting | named
    return abs(effect.size(values)) < 0.5 * matters


def _rough_levels(model: Model) -> list[float]:
    """First weights: scatter between neighbouring nodes and between repeats, the smaller."""
    runs = model.runs
    contrast = runs.contrast(runs.measured)
    spare = sum(len(g) - 1 for g in runs.groups) * runs.samples
    between = np.sqrt(np.sum(contrast**2, axis=(1, 2)) / max(spare, 1))
    near = np.sqrt(np.mean(np.diff(runs.measured, 2, axis=-1) ** 2, axis=(1, 2)) / 6.0)
    return [float(max(min(b, 4.0 * n), 1e-9)) for b, n in zip(between, near, strict=True)]
