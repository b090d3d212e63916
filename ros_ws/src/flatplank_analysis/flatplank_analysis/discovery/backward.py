# SPDX-License-Identifier: Apache-2.0
"""Backward elimination: accepted effects that are not needed any more are removed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from flatplank_analysis.discovery import invariants
from flatplank_analysis.discovery.decide import CONDITIONS, SHARE, Judge
from flatplank_analysis.discovery.fit import Fit, Fitter
from flatplank_analysis.discovery.steps import AcceptedEffect, Step

SECOND_GAP = 0.25
"""least drop by a gap beside another one, as a share of the drop by that alone: a backlash with an
oil film leaves 0.11 to 0.19, a second gap of the same size explains 0.38 to 0.46"""


@dataclass(frozen=True)
class Backward:
    """Repeats the tests of the accepted effects of a step, and removes what they refuse."""

    fitter: Fitter
    offset: int
    """number of effects that were in the model before the search"""
    looked_at: Mapping[str, int]
    """divisor of the family-wise level, by effect"""
    refused: Mapping[str, float]
    """effect that was refused for its form alone -> its `Decision.unevenness` then"""
    bare: float
    """fitted error of the first channel without found effects"""
    step_of: Callable[[Fit, list[AcceptedEffect]], Step]

    def __call__(self, step: Step) -> Step:
        """The step without the effects that are not needed beside the others.

        An effect that imitated a later one explains little beside it.
        """
        if len(step.found) < 2:
            return step
        step.found = self.retested(step)
        while len(step.found) > 1:
            idle = [
                i
                for i, f in enumerate(step.found)
                if not needed(f, step.found) or self.left_by_a_gap(step, i)
            ]
            if not idle:
                break
            # one at a time: two effects that explain the same would both be removed
            least = min(idle, key=lambda i: step.found[i].decision.drop)
            kept = [i for i in range(len(step.found)) if i != least]
            fit = step.state.fit
            terms = [*fit.terms[: self.offset], *(fit.terms[self.offset + i] for i in kept)]
            smaller = self.fitter.fit(fit.base, terms)
            if invariants.is_raised(invariants.error_of(self.fitter, smaller), self.bare):
                break
            step = self.step_of(smaller, [step.found[i] for i in kept])
            step.found = self.retested(step)
        return step

    def left_by_a_gap(self, step: Step, i: int) -> bool:
        """True for a gap that explains no more beside another gap than that may leave by its form,
        as a share (`SECOND_GAP`) of what it explains alone."""
        found = [f.decision.term.effect for f in step.found]
        alike = [j for j, effect in enumerate(found) if j != i and found[i].imitates(effect)]
        if not alike:
            return False
        state, drop = step.state, step.found[i].decision.drop
        less = state.fit_whitened(self.fitter.without_term(state.whitened.fit, self.offset + i))
        for j in alike:
            rest = self.fitter.without_term(less.fit, self.offset + j - (j > i))
            if drop < SECOND_GAP * (state.fit_whitened(rest).chi2 - less.chi2):
                return True
        return False

    def retested(self, step: Step) -> list[AcceptedEffect]:
        """The effects of a step, each tested against the model without it."""
        state = step.state
        uneven = uneven_terms(step, self.offset, self.refused)
        out = []
        for index, found in enumerate(step.found, self.offset):
            less = state.fit_whitened(self.fitter.without_term(state.whitened.fit, index))
            judge = Judge(state, less.chi2, step.screen.typical, uneven=uneven, bare=less.fit)
            looked = self.looked_at[found.decision.term.effect.identifier]
            decision = judge.decide(state.whitened, index, looked, plain=state.fit)
            out.append(replace(found, decision=decision))
        return out


def uneven_terms(
    step: Step, offset: int, refused: Mapping[str, float]
) -> tuple[tuple[int, float], ...]:
    """Found effects of a wrong form: index of the term, and how much the size differs.

    offset: number of effects before the found ones; refused: effects whose form was wrong before
    others were added, and how much their size differed then.
    """
    found = enumerate((f.decision for f in step.found), offset)
    odd = [
        (i, d.unevenness if d.misshapen else refused.get(d.term.effect.identifier, 0.0))
        for i, d in found
    ]
    return tuple((i, share) for i, share in odd if share > 0.0)


def needed(one: AcceptedEffect, found: Sequence[AcceptedEffect]) -> bool:
    """True when an effect still explains something beside the others.

    One that explains less than another is a further effect, whichever was found first.
    """
    own, others = one.decision, [f.decision for f in found if f is not one]
    further = own.drop < max(d.drop for d in others) and own.p_conditions > CONDITIONS
    beyond = own.p_repeats < own.level and not further
    return own.drop > SHARE * own.explained_by(others) and beyond and not own.covers_zero
