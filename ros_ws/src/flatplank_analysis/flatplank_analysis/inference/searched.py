# SPDX-License-Identifier: Apache-2.0
"""A search with the posterior behind it."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Fit
from flatplank_analysis.discovery.steps import Search
from flatplank_analysis.inference.answer import Answer
from flatplank_analysis.inference.posterior import Posterior
from flatplank_analysis.inference.weigh import Scales, Weighed


@dataclass(kw_only=True)
class Searched(Search):
    """The result of a search, and what weighs further runs in the same way."""

    scales: Scales
    answer: Answer

    @property
    def posterior(self) -> Posterior:
        return self.answer.posterior

    def rival_set(self, index: int, rival: str) -> Weighed:
        """The likeliest set with a rival in the place of found effect `index`."""
        place = self.answer.named[index].decision.place
        alternatives = self.posterior.alternatives(self.posterior.best, place)
        return next(w for w, at, _ in alternatives if w.names[at] == rival)

    def without(self, decision: Decision) -> Fit:
        """The likeliest set without one of its effects; nothing else changes."""
        return self.scales.fitter.without_term(self.posterior.best.fit, decision.place)
