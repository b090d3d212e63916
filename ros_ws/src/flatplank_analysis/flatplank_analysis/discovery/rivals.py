# SPDX-License-Identifier: Apache-2.0
"""Which effects could stand in for one that was found: each is refitted in its place.

Suspects are picked when the effect is taken: those whose columns look like its own once the model
has taken its part, and those that show in the same coordinate and promise as much. When the
search is over each of them takes the place of the effect, and everything is fitted again. Those
whose whitened sum of squares is no worse than the evidence asks for are its class.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flatplank_analysis.discovery.decide import SHARE, Decision, at_edge
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.screen import (
    VISIBLE,
    Screen,
    best_per_effect,
    likeness,
    settings_of,
)
from flatplank_analysis.discovery.shortlist import EVIDENCE, profile
from flatplank_analysis.discovery.state import State, term_of

NEARLY_ALIKE = 0.8
"""likeness of the columns from which on an effect is a suspect"""
PROMISE = 0.3
"""share of the drop that another effect of the same coordinate must promise to be one"""
ALIKE = 0.03
"""share of a drop that is no evidence between two effects: the law of the model is no better"""
JACOBIANS = 5
"""of the refit of a rival"""
CLOSE = 0.3
"""share of the drop by which a rival may stand behind and still be refitted to the end: a gap
moves slowly to the force at which it is crossed"""


@dataclass(frozen=True)
class Suspect:
    """An effect that might stand in for the one that was taken, and where its refit starts."""

    start: Term
    near: bool
    """its columns look alike, too"""


@dataclass(frozen=True)
class Rival:
    """A suspect after its refit in the place of the effect."""

    term: Term
    excess: float
    """whitened sum of squares beyond that with the effect"""
    near: bool
    excluded: bool
    """the data tell it from the effect"""

    @property
    def name(self) -> str:
        return self.term.effect.identifier


def indifferent(decision: Decision, explained: float = 0.0) -> float:
    """Difference of two sums of squares that is no evidence between two effects.

    explained: by all effects together; less than the share of it that makes an effect is none.
    A fault of another form leaves more than that, whatever its name.
    """
    evidence = EVIDENCE * max(decision.dispersion, 1.0)
    return max(evidence, ALIKE * decision.drop, SHARE * explained, decision.residue)


def suspects(model: Model, state: State, screen: Screen, decision: Decision) -> Iterator[Suspect]:
    """Effects that might stand in for one that is about to be added to a state."""
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
            start, gain = profile(model, state, item)
        if near or gain > PROMISE * decision.drop:
            yield Suspect(start, near)


def rivals(
    fitter: Fitter,
    state: State,
    index: int,
    decision: Decision,
    tried: Sequence[Suspect],
    explained: float,
) -> tuple[Rival, ...]:
    """The suspects of effect `index` after a refit in its place, the likeliest first."""
    present = {t.effect for t in state.fit.terms}
    less = fitter.shrunk(state.whitened.fit, index)
    out = []
    for suspect in tried:
        if suspect.start.effect in present:
            continue
        found = state.settle(fitter.grown(less, suspect.start), JACOBIANS)
        excess = found.chi2 - state.whitened.chi2
        if indifferent(decision, explained) < excess < CLOSE * decision.drop:
            found = state.settle(found.fit)
            excess = found.chi2 - state.whitened.chi2
        term = found.fit.terms[-1]
        small = abs(term.size) < term.effect.main_parameter().matters
        apart = excess > indifferent(decision, explained) or small or at_edge(term)
        out.append(Rival(term, excess, suspect.near, apart))
    return tuple(sorted(out, key=lambda r: r.excess))
