# SPDX-License-Identifier: Apache-2.0
"""The search: base, exploration of sets of effects, answer, in the form of `discovery.steps`."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flatplank_analysis.discovery import heldout, invariants
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.model import Model, starts_of
from flatplank_analysis.discovery.opening import Options, fitted_base, from_other_starts, opened
from flatplank_analysis.discovery.screen import best_per_effect, screen
from flatplank_analysis.discovery.state import State, make_state, start_base, term_of
from flatplank_analysis.discovery.steps import AcceptedEffect, Step
from flatplank_analysis.inference.answer import (
    Answer,
    answer_of,
    decision_of,
    present_without_name,
    runners_up,
    to_dict,
)
from flatplank_analysis.inference.detectable import detectable_sizes
from flatplank_analysis.inference.explore import REACH, Explorer
from flatplank_analysis.inference.posterior import Posterior
from flatplank_analysis.inference.searched import Searched
from flatplank_analysis.inference.weigh import Scales, Weighed, key_of

COLD = 3
"""most effects other than gaps that are fitted from the start values of the base"""


def run_search(
    model: Model, effects: Sequence[type[Effect]], options: Options | None = None
) -> Searched:
    """Search for the effects that a model lacks, by the posterior over sets of effects."""
    return _Inference(opened(model), list(effects), options or Options()).run()


@dataclass
class _Inference:
    model: Model
    effects: list[type[Effect]]
    options: Options
    began: float = field(default_factory=time.perf_counter)
    starts: int = 1
    """number of sets of start values of the base"""

    def run(self) -> Searched:
        self.say("fit of the base", 0.0)
        search = self.searched(fitted_base(self.model, self.effects, self.options))
        if not search.last.left:
            return search
        # a local minimum of the base leaves what no effect explains, or imitates one
        self.say("other starts", 0.9)
        first = search.steps[0].state
        better = None
        if starts_of(self.model):
            better = from_other_starts(first, self.effects, self.options)
            self.starts = search.starts = 1 + len(starts_of(self.model))
        restarted = self.restarted(better or first)
        if better is None and not restarted:
            return search
        return self.searched(better or first, restarted)

    def searched(self, base: State, restarted: Sequence[Fit] = ()) -> Searched:
        """The search from a fitted base, and from some fits with an effect."""
        fitted = time.perf_counter() - self.began
        scales = Scales.of(base, self.effects)
        first = Step(base, scales.ranking, [])
        sets = [scales.fitted(fit) for fit in (base.whitened.fit, *restarted)]
        explorer = self.explorer(scales, sets, 0.2)
        ranked = time.perf_counter() - self.began
        scales, posterior = self.explored(explorer)
        self.say("answer", 0.9)
        held = len(self.options.terms)
        answer, state = self.with_a_fall(base, answer_of(posterior, held), scales.state)
        answer = replace(answer, named=tuple(self.named(answer, state, scales)))
        last = Step(state, screen(state), list(answer.named), present_without_name(answer, held))
        steps = [first, last] if answer.terms[held:] else [last]
        return Searched(
            self.model, self.effects, steps, time.perf_counter() - self.began, fitted, ranked,
            self.starts, stated=to_dict(posterior), notes=tuple(runners_up(answer)),
            detectable=detectable_sizes(scales), scales=scales, answer=answer,
        )  # fmt: skip

    def restarted(self, state: State) -> list[Fit]:
        """Fits of the base from its start values together with each effect whose size acts in
        another way when it is large (a gap), and with the best others: without the effect the base
        may have ended where it imitates the effect, and the screening shows little of it."""
        cold = start_base(self.model, self.options.start)
        fits, others = [], 0
        for item in best_per_effect(screen(state)):
            effect = item.candidate.effect
            if len(effect.starts()) > 1:
                sizes = np.full(len(item.sizes), max(effect.starts()))
            elif others < COLD and np.any(item.sizes):
                others, sizes = others + 1, item.sizes
            else:
                continue
            term = term_of(item.candidate, sizes)
            fits.append(state.fitter.fit(cold, [*state.fit.terms, term]))
        return fits

    def named(self, answer: Answer, state: State, scales: Scales) -> Iterator[AcceptedEffect]:
        """The named effects with what they predict of left-out conditions, and their sizes in the
        model that has them: without an effect that has no name they may be others."""
        first, posterior = len(state.fit.terms) - len(answer.named), answer.posterior
        told = None
        if key_of(answer.terms) != posterior.best.key:
            told = scales.fitted(state.whitened.fit)
        for index, found in enumerate(answer.named, first):
            own = found.decision
            if told is not None:
                there = decision_of(posterior, told, index, own.probability)
                own = replace(own, term=there.term, interval=there.interval)
            gain = heldout.gain(state, state.fit, index)
            yield replace(found, decision=replace(own, held_out_gain=gain))

    def say(self, text: str, share: float) -> None:
        if self.options.progress is not None:
            self.options.progress(text, share)

    def explorer(self, scales: Scales, sets: Sequence[Weighed], share: float) -> Explorer:
        """An explorer of some sets; share: of the search that is done."""
        explorer = Explorer(
            scales, held=len(self.options.terms), measured=self.options.measured,
            say=lambda text: self.say(text, share),
        )  # fmt: skip
        for weighed in sets:
            explorer.keep(weighed)
        return explorer

    def explored(self, explorer: Explorer) -> tuple[Scales, Posterior]:
        """Explore, estimate the noise with the likeliest set in the model, and explore again."""
        base, scales = explorer.scales.state, explorer.scales
        posterior = explorer.run()
        best = posterior.best
        if best.key == key_of(base.fit.terms):
            return scales, posterior
        self.say(f"noise beside {', '.join(best.key)}", 0.5)
        order = sorted(range(len(best.fit.terms)), key=lambda i: posterior.matters(best, i))
        state = self.state_of(base, best, [best.fit.terms[i] for i in order])
        scales = Scales.of(state, self.effects)
        near = [posterior.sets[k] for k, log in posterior.logs.items() if log > -2.0 * REACH]
        done = explorer.extended - {best.key}
        fits = [base.whitened.fit, *(w.fit for w in near if w.fit.terms[len(base.fit.terms) :])]
        explorer = self.explorer(scales, [scales.fitted(fit) for fit in fits], 0.7)
        explorer.extended = done
        return scales, explorer.run()

    def with_a_fall(self, base: State, answer: Answer, state: State) -> tuple[Answer, State]:
        """The answer without names that do not lower the plain error, and its state.

        state: one with the likeliest set.
        """
        best = answer.posterior.best
        while True:
            if [t.effect for t in answer.terms] != [t.effect for t in state.fit.terms]:
                state = self.state_of(base, best, answer.terms)
            least_gain_first = reversed(answer.named)
            flat = next(
                (f for f in least_gain_first if not self._lowers_error(base, state, best, f)),
                None,
            )
            if flat is None:
                return answer, state
            named = tuple(f for f in answer.named if f is not flat)
            answer = replace(answer, named=named, flat=(*answer.flat, flat))

    def _lowers_error(
        self, base: State, state: State, best: Weighed, found: AcceptedEffect
    ) -> bool:
        """False when the plain error is the same without a named effect, wherever the fit without
        it begins."""
        fit, fitter = state.fit, state.fitter
        term = best.fit.terms[found.decision.place]
        effect, size = term.effect, term.size
        own = [i for i, t in enumerate(fit.terms) if t.effect is effect]
        index = min(own, key=lambda i: abs(fit.terms[i].size - size))
        start = fitter.without_term(fit, index)
        fits = [
            fitter.fit(start.base, start.terms, known=start),
            fitter.fit(base.fit.base, start.terms),
        ]
        if not start.terms[len(base.fit.terms) :]:
            fits.append(base.fit)
        measured = state.runs.measured
        return not invariants.is_no_fall(
            [f.residual(measured) for f in fits], fit, index, measured
        )

    def state_of(self, base: State, best: Weighed, terms: Sequence[Term]) -> State:
        """State with some effects of a set; together they do not raise the fitted error."""
        fitter, near = base.fitter, self._near(best, terms)
        fit = fitter.fit(best.fit.base, terms, known=near)
        if invariants.is_raised(*(invariants.error_of(fitter, f) for f in (fit, base.fit))):
            fit = self._one_by_one(base, best, terms)
        return make_state(self.model, fitter, fit, self.effects, near)

    def _one_by_one(self, base: State, best: Weighed, terms: Sequence[Term]) -> Fit:
        """A fit with some effects, of which none raises the fitted error."""
        fitter, fit = base.fitter, base.fit
        for term in terms[len(fit.terms) :]:
            fits = [fitter.fit(b, [*fit.terms, term]) for b in (fit.base, best.fit.base)]
            fit = invariants.not_raising_error(fitter, fit, fits)
        return fit

    def _near(self, best: Weighed, terms: Sequence[Term]) -> Fit | None:
        """The whitened fit of the set, where its effects are in the same order."""
        same = [t.effect for t in best.fit.terms] == [t.effect for t in terms]
        return best.fit if same else None
