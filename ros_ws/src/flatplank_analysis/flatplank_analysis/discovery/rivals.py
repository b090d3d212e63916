# SPDX-License-Identifier: Apache-2.0
"""Effects that the runs may not distinguish from a found one: each is refitted in its place.

Suspects are selected when the effect is added: effects whose columns resemble its own after the
model has taken its part, and effects over the same coordinate with a similar expected drop. After
the search each suspect replaces the effect, and everything is fitted again. The suspects whose
whitened sum of squares is not significantly larger form the class of the effect.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flatplank_analysis.discovery.decide import SHARE, Judge, at_edge
from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Fitter, Term, Whitened
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.screen import (
    VISIBLE,
    Screen,
    best_per_effect,
    likeness,
    settings_of,
)
from flatplank_analysis.discovery.shortlist import EVIDENCE, line_search_with_drop
from flatplank_analysis.discovery.state import State, term_of

NEARLY_ALIKE = 0.8
"""likeness of the columns above which an effect is a suspect"""
PROMISE = 0.3
"""least expected drop of a suspect over the same coordinate, as a share of the effect's drop"""
ALIKE = 0.03
"""relative difference of two drops that does not decide between effects: error of the law"""
JACOBIANS = 5
"""Jacobians of the first refit of a rival"""
CLOSE = 0.3
"""excess of a rival, as a share of the drop, below which its refit is continued to the end: the
force at which a gap is crossed converges slowly"""


@dataclass(frozen=True)
class AlternativeEffect:
    """An effect that may explain the same as an accepted one, and the start of its refit."""

    start: Term
    near: bool
    """True when its columns resemble those of the effect"""


@dataclass(frozen=True)
class Rival:
    """A suspect after its refit in the place of the effect."""

    term: Term
    excess: float
    """whitened sum of squares beyond that with the effect"""
    near: bool
    excluded: bool
    """True when the data exclude it, or its size is negligible or at the end of its range"""

    @property
    def name(self) -> str:
        return self.term.effect.identifier


def indecisive_difference(decision: Decision, found: Sequence[Decision] = ()) -> float:
    """Difference of two sums of squares that does not decide between two effects.

    found: all effects; `SHARE` of what they explain together is the least drop of any.
    A fault of another form leaves a larger residue, which does not decide either.
    """
    evidence = EVIDENCE * max(decision.dispersion, 1.0)
    least = SHARE * decision.explained_by(found)
    return max(evidence, ALIKE * decision.drop, least, decision.residue)


def suspects(
    model: Model, state: State, screen: Screen, decision: Decision
) -> Iterator[AlternativeEffect]:
    """Effects that may explain the same as one that is about to be added to a state."""
    own = decision.term.effect
    mine = settings_of(screen, own.identifier)
    for item in best_per_effect(screen):
        effect = item.candidate.effect
        if effect is own or effect.generic or item.visible < VISIBLE / 3:
            continue
        near = bool(mine) and likeness(screen, mine[0], item) > NEARLY_ALIKE
        if not near and effect.coordinate != own.coordinate:
            continue
        start, gain = term_of(item.candidate, item.sizes), item.gain
        if len(effect.starts()) > 1:
            start, gain = line_search_with_drop(model, state, item)
        if near or gain > PROMISE * decision.drop:
            yield AlternativeEffect(start, near)


def rivals(
    fitter: Fitter,
    judge: Judge,
    index: int,
    decision: Decision,
    tried: Sequence[AlternativeEffect],
    found: Sequence[Decision],
) -> tuple[Rival, ...]:
    """The suspects of effect `index` after a refit in its place, the likeliest first.

    judge: tests in the place of the effect; found: all effects of its state.
    """
    state = judge.state
    present = {t.effect for t in state.fit.terms}
    undecided = indecisive_difference(decision, found)
    less = fitter.without_term(state.whitened.fit, index)
    out = []
    for suspect in tried:
        if suspect.start.effect in present:
            continue
        refit = state.fit_whitened(fitter.with_term(less, suspect.start), JACOBIANS)
        excess = refit.chi2 - state.whitened.chi2
        if undecided < excess < CLOSE * decision.drop:
            refit = state.fit_whitened(refit.fit)
            excess = refit.chi2 - state.whitened.chi2
        term = refit.fit.terms[-1]
        small = abs(term.size) < term.effect.main_parameter().matters
        apart = excess > undecided and not _of_wrong_form(judge, decision, refit, excess)
        out.append(Rival(term, excess, suspect.near, apart or small or at_edge(term)))
    return tuple(sorted(out, key=lambda r: r.excess))


def _of_wrong_form(judge: Judge, decision: Decision, refit: Whitened, excess: float) -> bool:
    """True when neither an effect nor its rival has the form of the fault: that the rival explains
    less does not decide then."""
    if not decision.misshapen or excess > CLOSE * decision.drop:
        return False
    rival = judge.decide(refit, len(refit.fit.terms) - 1, 1)
    return rival.accepted or rival.misshapen
