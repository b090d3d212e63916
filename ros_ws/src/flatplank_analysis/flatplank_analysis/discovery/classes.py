# SPDX-License-Identifier: Apache-2.0
"""The class of every found effect; a better member takes the place of one of a wrong form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.decide import Judge
from flatplank_analysis.discovery.fit import Fit, Fitter
from flatplank_analysis.discovery.rivals import AlternativeEffect, Rival, rivals
from flatplank_analysis.discovery.shortlist import EVIDENCE
from flatplank_analysis.discovery.steps import AcceptedEffect, Step


@dataclass(frozen=True)
class Classes:
    """Finds the rivals of the effects of a step."""

    fitter: Fitter
    offset: int
    """number of effects that were in the model before the search"""
    retested: Callable[[Step], list[AcceptedEffect]]
    """`Backward.retested`"""
    step_of: Callable[[Fit, list[AcceptedEffect], Fit], Step]
    """step of a plain fit, with its found effects and a whitened fit"""

    def __call__(self, step: Step) -> Step:
        """The step with the rivals of all effects, and with the first one that a rival explains
        better replaced by it."""
        step.found = self.with_rivals(step)
        for i, found in enumerate(step.found):
            best = better_rival(found)
            if best is not None:
                after = self.replaced(step, i, best)
                after.found = self.with_rivals(after)
                return after
        return step

    def with_rivals(self, step: Step) -> list[AcceptedEffect]:
        """The effects of a step, each with its rivals."""
        state, found, out = step.state, [f.decision for f in step.found], []
        for i, f in enumerate(step.found, self.offset):
            judge = Judge(state, state.whitened.chi2 + f.decision.drop, step.screen.typical)
            others = rivals(self.fitter, judge, i, f.decision, f.suspects, found)
            out.append(replace(f, rivals=others))
        return out

    def replaced(self, step: Step, i: int, rival: Rival) -> Step:
        """The step with found effect `i` replaced by a rival, and fitted again."""
        state, fitter, found = step.state, self.fitter, step.found[i]
        less = fitter.without_term(state.whitened.fit, self.offset + i)
        near = state.fit_whitened(fitter.with_term(less, rival.term)).fit
        fits = [fitter.fit(base, near.terms) for base in (state.fit.base, near.base)]
        without = fitter.fit(state.fit.base, less.terms)
        fit = invariants.not_raising_error(fitter, without, fits)
        old = AlternativeEffect(found.decision.term, rival.near)
        others = [s for s in found.suspects if s.start.effect is not rival.term.effect]
        new = AcceptedEffect(replace(found.decision, term=rival.term), (old, *others))
        kept = [f for f in step.found if f is not found]
        after = self.step_of(fit, [*kept, new], near)
        after.found = self.retested(after)
        return after


def better_rival(found: AcceptedEffect) -> Rival | None:
    """The rival that explains more than an effect of a wrong form; of several whose difference is
    no evidence the most common one."""
    evidence = EVIDENCE * max(found.decision.dispersion, 1.0)
    better = [r for r in found.rivals if not r.excluded and r.excess < -evidence]
    if not better or not found.decision.misshapen:
        return None
    near = [r for r in better if r.excess < better[0].excess + evidence]
    return min(near, key=lambda r: r.term.effect.rarity)
