# SPDX-License-Identifier: Apache-2.0
"""One more effect beside a model: is it there, and what may stand in its place?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flatplank_analysis.discovery.decision import IMITATED, Decision
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fit, Term
from flatplank_analysis.discovery.state import State
from flatplank_analysis.inference.answer import decision_of, doubt_about
from flatplank_analysis.inference.explore import Explorer
from flatplank_analysis.inference.posterior import NAMED, Posterior
from flatplank_analysis.inference.weigh import Scales, Weighed


@dataclass(frozen=True)
class Beside:
    """A model with which others that have one effect more are weighed."""

    scales: Scales
    model: Weighed

    @classmethod
    def of(cls, state: State, effects: Sequence[type[Effect]]) -> Beside:
        """Beside the model of a state; effects: those that are looked for."""
        scales = Scales.of(state, effects)
        return cls(scales, scales.fitted(state.whitened.fit))

    def among(self, count: float) -> Beside:
        """The same where the effect is one of so many that were looked at."""
        scales = replace(self.scales, library=count)
        return replace(self, scales=scales, model=scales.weighed(self.model.fit))

    def with_term(self, term: Term) -> Weighed:
        """The model with one more effect."""
        return self.scales.with_term(self.model.fit, term)

    def posterior(self, *others: Weighed) -> Posterior:
        """The posterior over the model and others."""
        sets = {w.key: w for w in (self.model, *others)}
        return Posterior(sets, self.scales.freedom, self.scales.dispersion)

    def decide(self, weighed: Weighed) -> Decision:
        """The decision about the last effect of a set, against the model without it."""
        posterior, index = self.posterior(weighed), len(weighed.fit.terms) - 1
        term = weighed.fit.terms[index]
        name = term.effect.identifier
        probability = posterior.in_set([name], weighed.names.count(name))
        reasons = []
        if probability < NAMED:
            reasons.append(doubt_about(posterior, weighed, index, probability))
        if not term.effect.separable(self.scales.state.runs, term.named()):
            reasons.append(IMITATED)
        return decision_of(posterior, weighed, index, probability, *reasons)

    def instead_of(self, weighed: Weighed) -> list[Term]:
        """The class of the last effect of a set: effects of which one may stand in its place, the
        likeliest first."""
        explorer = Explorer(self.scales, held=len(self.model.fit.terms))
        for one in (self.model, weighed):
            explorer.sets[one.key] = one
        explorer.extend(self.model.fit)
        rivals = explorer.posterior.rivals(weighed, len(weighed.fit.terms) - 1)
        return [r.term for r in rivals if not r.excluded]

    def fitted(self, start: Fit) -> Weighed:
        """The joint fit from a start."""
        return self.scales.fitted(start)
