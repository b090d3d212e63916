# SPDX-License-Identifier: Apache-2.0
"""Forward search with real refits, backward elimination after each step."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flatplank_analysis.discovery import heldout, invariants
from flatplank_analysis.discovery import screen as screens
from flatplank_analysis.discovery.backward import Backward, uneven_terms
from flatplank_analysis.discovery.classes import Classes
from flatplank_analysis.discovery.decide import NEARLY, Judge
from flatplank_analysis.discovery.decision import FLAT, IMITATED, UNEVEN, Decision
from flatplank_analysis.discovery.effect import Effect, variants_of
from flatplank_analysis.discovery.fit import Fit, Fitter, Term, Whitened
from flatplank_analysis.discovery.model import Model, starts_of
from flatplank_analysis.discovery.refits import Refit, Refits, by_drop, preferred
from flatplank_analysis.discovery.rivals import ALIKE, indecisive_difference, suspects
from flatplank_analysis.discovery.shortlist import EVIDENCE, mostly_imitated, shortlist
from flatplank_analysis.discovery.sources import UNDECIDED, cut_where_needed, source_of
from flatplank_analysis.discovery.state import (
    State,
    channel_weights,
    make_state,
    rough_levels,
    start_base,
)
from flatplank_analysis.discovery.steps import AcceptedEffect, Progress, Search, Step
from flatplank_data.errors import FlatplankError

IDLE = "not needed beside what was found"
"""reason for an effect that was added and then removed by backward elimination"""
FIRST_STEPS = 6
"""iterations from each further set of start values, before the best one is fitted to the end"""
WORTH_A_FIT = 0.9
"""largest ratio of the errors at which a base that was fitted with the weights of the floors
replaces the first one; otherwise that is at their optimum already"""


@dataclass
class Options:
    """Settings of the search."""

    most: int = 4
    """largest number of effects"""
    refits: int = 5
    """candidates that are refitted per step"""
    progress: Progress | None = None
    start: dict[str, float] = field(default_factory=dict)
    """start values of base parameters"""
    terms: tuple[Term, ...] = ()
    """effects that are in the model already"""
    measured: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """effect -> parameter -> value [SI] measured on the machine, used as start value"""


def run_search(
    model: Model, effects: Sequence[type[Effect]], options: Options | None = None
) -> Search:
    """Search for the effects that a model lacks."""
    return _Searcher(opened(model), list(effects), options or Options()).run()


def opened(model: Model) -> Model:
    """The model with its runs as a search takes them; FlatplankError without a floor."""
    model = cut_where_needed(model)
    if source_of(model.runs).at_most == UNDECIDED:
        raise FlatplankError("no repeats", "campaign", "repeat at least one condition")
    return model


def fit_from_other_starts(fitter: Fitter, options: Options) -> tuple[Fit, int]:
    """The base from the best of its further start values, and how many there are.

    A few iterations from each set of start values select the one that is fitted to the end.
    """
    starts = [{**options.start, **other} for other in starts_of(fitter.model)]
    bases = [start_base(fitter.model, start) for start in starts]
    tries = [fitter.fit(b, options.terms, iterations=FIRST_STEPS) for b in bases]
    begun = min(tries, key=lambda f: f.chi2)
    return fitter.fit(begun.base, begun.terms, known=begun), len(starts)


def bonferroni_divisors(effects: Sequence[type[Effect]], model: Model) -> dict[str, int]:
    """Divisor of the family-wise level, by effect (weighted Bonferroni).

    Every effect gets the same share of the level; an effect that is tested at many places or
    periods divides its own share, not that of the others.
    """
    return {
        e.identifier: len(effects) * max(len(e.linear()), 1) * e.scanned(model.runs)
        for e in effects
    }


def fit_with_law_effects(search: Search) -> State | None:
    """The last state with all effects of the force law (`Effect.law`) added and fitted; None when
    there are no further ones."""
    last = search.last.state
    present = {t.effect for t in last.fit.terms}
    pieces = [e for e in search.effects if e.law and e not in present]
    if not pieces:
        return None
    settings = [(e, variants_of(e, search.model.runs, last.residual)) for e in pieces]
    terms = [Term(e, e.vector(s[0]), e.held()) for e, s in settings if s]
    weight = channel_weights(search.model, [f.floor for f in last.floors])
    fitter = Fitter(search.model, weight)
    fit = fitter.fit(last.fit.base, [*last.fit.terms, *terms], iterations=10)
    return make_state(search.model, fitter, fit, [])


class _Searcher:
    def __init__(self, model: Model, effects: list[type[Effect]], options: Options) -> None:
        self.model, self.effects, self.options = model, effects, options
        self.began = time.perf_counter()
        self.fitter = Fitter(model, channel_weights(model, rough_levels(model)))
        self.looked_at = bonferroni_divisors(effects, model)
        self.starts = 1
        """number of sets of start values of the base"""
        self.bare = np.inf
        """fitted error of the first channel without found effects"""
        self.known: set[frozenset[str]] = set()
        """effects of the steps so far"""
        self.refused: dict[str, float] = {}
        """effect that was refused for its form alone -> its `Decision.unevenness` then"""

    @property
    def refits(self) -> Refits:
        """Refits with the channel weights of now."""
        options = self.options
        return Refits(self.model, self.fitter, options.start, options.measured, self.looked_at)

    @property
    def backward(self) -> Backward:
        """Backward elimination with the channel weights of now."""
        return Backward(
            self.fitter, len(self.options.terms), self.looked_at, self.refused, self.bare,
            self.step_of,
        )  # fmt: skip

    @property
    def classes(self) -> Classes:
        """Finds the classes of found effects with the channel weights of now."""
        return Classes(self.fitter, len(self.options.terms), self.backward.retested, self.step_of)

    def say(self, text: str, share: float) -> None:
        if self.options.progress is not None:
            self.options.progress(text, share)

    def run(self) -> Search:
        self.say("fit of the base", 0.0)
        base = start_base(self.model, self.options.start)
        fit = self.fitter.fit(base, self.options.terms)
        fitted = time.perf_counter() - self.began
        step = self.from_other_starts(self.with_weights_of_floors(self.step_of(fit, [])))
        self.bare = invariants.error_of(self.fitter, step.state.fit)
        first = time.perf_counter() - self.began
        steps = self.continued([step])
        single = self.single_effect_step(steps)
        if single is not None:
            steps = self.continued([steps[0], single])
        self.say("effects that could stand in for what was found", 0.9)
        steps = [*steps[:-1], self.classes(steps[-1])]
        seconds = time.perf_counter() - self.began
        return Search(
            self.model, self.effects, steps, seconds, self.looked_at, fitted, first, self.starts
        )

    def continued(self, steps: list[Step]) -> list[Step]:
        """These steps and all that follow from the last one."""
        for number in range(len(steps) - 1, self.options.most):
            self.say(f"refits, step {number + 1}", 0.2 + 0.15 * number)
            self.known = {_names(s) for s in steps}
            after = self.forward(steps[-1])
            if after is None:
                break
            steps.append(after)
        return steps

    def single_effect_step(self, steps: list[Step]) -> Step | None:
        """A step with one effect that explains more than all found effects together.

        The effect was refused for its form alone; the found effects imitate it.
        """
        first, found = steps[0], steps[-1].found
        odd = [d for d in first.refits if d.misshapen]
        if not odd or all(f.decision.term.effect.generic for f in found):
            return None
        best = max(odd, key=lambda d: d.drop)
        if any(f.decision.term.effect is best.term.effect for f in found):
            return None
        state = first.state
        together = state.fit_whitened(steps[-1].state.whitened.fit)
        evidence = EVIDENCE * max(best.dispersion, 1.0)
        if best.drop < state.whitened.chi2 - together.chi2 + evidence:
            return None
        judge = Judge(state, state.whitened.chi2, first.screen.typical)
        start = state.with_term(best.term, most=2)
        alone = [(best, start)]
        return self.take(first, judge, alone, alone, misshapen=True)

    def from_other_starts(self, step: Step) -> Step:
        """The step, or a better one from other start values of the base when a residual remains.

        A fit may end in a local minimum, whose residual is no effect.
        """
        state = step.state
        far = [
            f.unexplained > invariants.limits(state, c).rest for c, f in enumerate(state.floors)
        ]
        if not any(far) or not starts_of(self.model):
            return step
        self.say("other starts of the base", 0.17)
        fit, others = fit_from_other_starts(self.fitter, self.options)
        self.starts = 1 + others
        better = self.fitter.error(fit) < self.fitter.error(state.fit)
        return self.step_of(fit, []) if better else step

    def with_weights_of_floors(self, step: Step) -> Step:
        """The step with the channel weights of its floors, and the base fitted with them.

        The first weights come from the scatter alone. A base that is not at the optimum of the
        weights that all later fits use would itself change when an effect is added. With one
        channel the weights are a common factor.
        """
        state = step.state
        weight = channel_weights(self.model, [f.floor for f in state.floors])
        self.fitter = Fitter(self.model, weight)
        if len(state.floors) == 1:
            return step
        fits = [self.fitter.fit(f.base, f.terms, known=f) for f in (state.fit, state.whitened.fit)]
        best = min(fits, key=lambda f: f.chi2)
        better = self.fitter.error(best) < WORTH_A_FIT * self.fitter.error(state.fit)
        return self.step_of(best, []) if better else step

    def step_of(self, fit: Fit, found: list[AcceptedEffect], near: Fit | None = None) -> Step:
        """State and ranking; near: a whitened fit of the same terms."""
        self.say("screening", 0.15)
        state = make_state(self.model, self.fitter, fit, self.effects, near)
        return Step(state, screens.screen(state), found)

    def forward(self, step: Step) -> Step | None:
        """Refit the best candidates and add the best one that passes all tests."""
        state = step.state
        # by the noise of this state; a single effect has its drop by that of the state before
        found = self.backward.retested(step) if len(step.found) == 1 else step.found
        near = [(s.start.effect.identifier, f) for f in step.found for s in f.suspects if s.near]
        alike = {name: indecisive_difference(f.decision) for name, f in near}
        judge = Judge(
            state,
            state.whitened.chi2,
            step.screen.typical,
            tuple(f.decision for f in found),
            uneven=uneven_terms(step, len(self.options.terms), {}),
            alike=alike,
        )
        items = shortlist(step.screen, self.looked_at, self.options.refits)
        items += mostly_imitated(step.screen, items)
        tried, rest = self.refits.of(judge, items)
        step.refits = sorted([*(d for d, _ in tried), *rest], key=lambda d: -d.drop)
        odd = [d for d in step.refits if d.misshapen]
        self.refused |= {d.term.effect.identifier: d.unevenness for d in odd}
        taken = self.take(step, judge, tried, preferred(tried))
        if taken is None and step.left:
            more = self.refits.with_start_sizes(judge, step.screen, items)
            step.refits += [d for d, _ in more]
            taken = self.take(step, judge, more, preferred(more))
            tried = by_drop([*tried, *more])
        return taken or self.complete(step, judge, tried)

    def complete(self, step: Step, judge: Judge, tried: list[Refit]) -> Step | None:
        """Add an effect refused for its form, when the form is nearly right (`NEARLY`) or no
        residual of consequence remains beside it.
        """
        best = preferred(completable(tried, step.found))[:1]
        taken = self.take(step, judge, tried, best, misshapen=True) if best else None
        if taken is None or taken.found[-1].decision.unevenness < NEARLY:
            return taken
        return None if taken.left else taken

    def take(
        self,
        step: Step,
        judge: Judge,
        tried: list[Refit],
        chosen: Sequence[Refit],
        misshapen: bool = False,
    ) -> Step | None:
        """The step with the first refit that passes all tests, after backward elimination.

        tried: all refits, beside which an added one must stand; chosen: those of them that may be
        added, in this order; misshapen: a wrong form is permitted. A refit that is eliminated
        itself, or that leads back to the effects of an earlier step, is refused, and so is a free
        form of the law where nothing of consequence is left. None when no refit passes.
        """
        state = step.state
        for first, near in chosen:
            if first.term.effect.generic and not step.left:
                continue
            best = state.fit_whitened(near.fit)
            fair, decision, best = self.tested(judge, best)
            # later steps start from this base
            if passes(decision, misshapen) and best.fit.at_bound and not step.found:
                restarted = self.refits.restarted(state, best)
                fair, decision, best = self.tested(judge, restarted)
            if not passes(decision, misshapen):
                self.correct(step, tried, (decision, best), near)
                continue
            if not self.stands_beside_stronger(fair, decision, tried, misshapen):
                continue
            # from both bases, because one of them may end at limits of the force law
            fits = [self.fitter.fit(b, best.fit.terms) for b in (state.fit.base, best.fit.base)]
            fit = invariants.not_raising_error(self.fitter, state.fit, fits)
            if not invariants.is_active(fit.terms[-1]):
                continue
            if invariants.is_fall_by_chance(state, fit):
                step.refits = [
                    replace(d, reasons=(FLAT,)) if d.term.effect is best.fit.terms[-1].effect
                    else d
                    for d in step.refits
                ]  # fmt: skip
                continue
            decision = replace(
                decision, held_out_gain=heldout.gain(state, fit, len(fit.terms) - 1)
            )
            taken = AcceptedEffect(
                decision, tuple(suspects(self.model, state, step.screen, decision))
            )
            after = self.backward(self.step_of(fit, [*step.found, taken], near=best.fit))
            name = taken.decision.term.effect.identifier
            if name in _names(after) and _names(after) not in self.known:
                return after
            step.refits = [
                replace(d, reasons=(IDLE,)) if d.term.effect.identifier == name else d
                for d in step.refits
            ]
        return None

    def tested(self, judge: Judge, found: Whitened) -> tuple[Judge, Decision, Whitened]:
        """The tests of the last effect of a fit, the judge that made them, and the fit.

        The base found with the effect may also fit better without it; where that is better than
        with it, the effect is fitted again from there.
        """
        state, index = judge.state, len(found.fit.terms) - 1
        less = state.fit_whitened(self.fitter.without_term(found.fit, index))
        if less.chi2 < found.chi2:
            again = state.fit_whitened(self.fitter.with_term(less.fit, found.fit.terms[-1]))
            found = min(found, again, key=lambda fit: fit.chi2)
        fair = replace(judge, without=min(judge.without, less.chi2))
        return fair, self.refits.newest(fair, found), found

    def correct(self, step: Step, tried: list[Refit], now: Refit, before: Whitened) -> None:
        """Put a refit that was carried to its end in the place of the first one, `before`: an
        effect that passed there may be one of a wrong form here, which `complete` adds."""
        decision = now[0]
        tried[:] = [now if fit is before else (d, fit) for d, fit in tried]
        same = decision.term.effect
        step.refits = [decision if d.term.effect is same else d for d in step.refits]
        if decision.misshapen:
            self.refused[same.identifier] = decision.unevenness

    def stands_beside_stronger(
        self,
        judge: Judge,
        decision: Decision,
        tried: list[Refit],
        misshapen: bool,
    ) -> bool:
        """False when an effect fails the tests beside something stronger that is not named itself.

        That is a free form of the force law (the tire has another law, and no fault), or an effect
        of no consequence, whatever its form, which is there and explains it. Both are compared by
        their drop minus the price of their parameters (BIC); an `indecisive_difference` is not
        stronger.
        """
        if decision.term.effect.generic:
            return True
        for other, fit in tried:
            law = other.term.effect.generic and other.p_repeats <= other.level
            if not (law or other.present):
                continue
            price = math.log(judge.state.independent)
            own = decision.drop - price * decision.parameters
            if other.drop - price * other.parameters < own + indecisive_difference(decision):
                continue
            both = judge.state.fit_whitened(self.fitter.with_term(fit.fit, decision.term))
            beside = self.refits.newest(replace(judge, without=fit.chi2), both)
            if not passes(beside, misshapen):
                return False
        return True


def completable(tried: Sequence[Refit], found: Sequence[AcceptedEffect]) -> list[Refit]:
    """Refits of a wrong form that may be added.

    They must explain more than every effect that the runs can show and whose size differs even
    more, and more than found effects may leave (`ALIKE`). They must not be able to stand in for a
    found effect of a wrong form: they may be what that form leaves.
    """
    before = [f.decision for f in found]
    worse = [
        d.drop
        for d, _ in tried
        if d.p_repeats <= d.level
        and set(UNEVEN) & set(d.reasons)
        and IMITATED not in d.reasons
        and not (d.misshapen or d.term.effect.generic)
    ]
    wrong = [f for f in found if f.decision.misshapen]
    same = {s.start.effect for f in wrong for s in f.suspects}
    return [
        (d, fit)
        for d, fit in tried
        if d.misshapen
        and d.drop > max([*worse, ALIKE * d.explained_by(before)])
        and d.term.effect not in same
    ]


def passes(decision: Decision, misshapen: bool) -> bool:
    """True when an effect is accepted; misshapen: also with a wrong form."""
    return decision.accepted or (misshapen and decision.misshapen)


def _names(step: Step) -> frozenset[str]:
    return frozenset(f.decision.term.effect.identifier for f in step.found)
