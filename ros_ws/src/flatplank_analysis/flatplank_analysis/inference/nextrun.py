# SPDX-License-Identifier: Apache-2.0
"""The planned run after which the posterior tells the effects of a class apart.

A prediction counts as the posterior does: each of two effects is fitted to what the other one
predicts, in the present and the planned runs together, with all errors of the model. The run must
exclude the wrong one whichever of the two is true.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from scipy.stats import norm

from flatplank_analysis.discovery.model import Model
from flatplank_analysis.inference.contrast import Contrast, Part
from flatplank_analysis.inference.posterior import MEMBER, log_evidence
from flatplank_analysis.inference.searched import Searched
from flatplank_analysis.inference.weigh import Weighed

MOST_RUNS = 30
"""most runs of a proposal: those of a usual campaign"""
KEPT = float(norm.ppf(0.95))
"""standard deviations by which an expected difference exceeds what decides: the noise of the new
runs breaks one promise in twenty"""
EXCLUDED = math.log(MEMBER)
"""logarithm of the odds below which an effect is no member of a class"""
NO_RUN = "none of the planned runs tells these apart; check on the machine"


class PlannedRun(Protocol):
    """A run that the bench can make."""

    @property
    def text(self) -> str: ...

    @property
    def settings(self) -> dict[str, Any]: ...

    @property
    def model(self) -> Model: ...


class Pair:
    """Two sets of effects that differ in one: what planned runs would say of the first one if the
    second one were true."""

    def __init__(self, found: Searched, wrong: Weighed, true: Weighed) -> None:
        self.posterior = posterior = found.posterior
        self.runs = found.model.runs.runs
        self.contrast = Contrast(found.scales, wrong.fit, [true.fit.parameter_set()])
        (one, volume), (other, beside) = (posterior.fit_and_price(w) for w in (wrong, true))
        self.excess, self.volume = one - other, volume - beside

    def odds(self, more: float, runs: int = 0) -> float:
        """Logarithm of the odds of the wrong set when it leaves so much more than now, after so
        many runs more, which make the level of the noise better known."""
        excess, p = self.excess + more, self.posterior
        side, freedom = math.copysign(1.0, excess), p.freedom * (1.0 + runs / self.runs)
        return side * log_evidence(abs(excess), 0.0, freedom, p.dispersion) + self.volume

    def promise(self, parts: Sequence[Part], runs: int) -> tuple[float, float]:
        """Logarithm of the odds of the wrong set after planned runs: expected, and the most that
        the noise of these runs leaves in nineteen of twenty cases."""
        (more,) = self.contrast.gain(*parts)
        # a log likelihood ratio varies by twice its root; the dispersion is that of the noise
        chance = 2.0 * KEPT * math.sqrt(more * max(self.posterior.dispersion, 1.0))
        return self.odds(float(more), runs), self.odds(float(more) - chance, runs)


class Question:
    """Whether planned runs would tell a found effect from a rival."""

    def __init__(self, found: Searched, index: int, rival: str) -> None:
        self.names = found.last.found[index].decision.term.effect.identifier, rival
        best, other = found.posterior.best, found.rival_set(index, rival)
        self.pairs = Pair(found, other, best), Pair(found, best, other)

    def promise(
        self, parts: Sequence[Sequence[Part]], repeats: int, runs: int
    ) -> tuple[float, float]:
        """The same for the worse of both cases; parts: for each pair, of `runs` runs."""
        made = [
            pair.promise([part.times(repeats) for part in own], repeats * runs)
            for pair, own in zip(self.pairs, parts, strict=True)
        ]
        return max(made, key=lambda one: one[1])


@dataclass(frozen=True)
class Offer:
    """A planned run with the number of repeats at which it decides most questions."""

    plan: PlannedRun
    repeats: int
    decides: tuple[Question, ...]
    odds: float
    """logarithm of the largest odds that are expected to be left to a wrong effect"""

    @property
    def rank(self) -> tuple[int, float, float]:
        """The best offer has the least rank: of those that decide most, the shortest."""
        time = float(self.plan.model.runs.time[:, -1].sum())
        return -len(self.decides), self.repeats * time, self.odds


def next_run(found: Searched, plans: Sequence[PlannedRun]) -> dict[str, Any]:
    """The planned run that with the fewest repeats excludes the rivals of most indistinguishable
    pairs, as the JSON of a diagnosis has it; {} without such pairs."""
    pairs = [(i, name) for i, f in enumerate(found.last.found) for name in f.alike]
    if not pairs or not plans:
        return {}
    each = [Question(found, i, rival) for i, rival in pairs]
    best = min((_offer(each, plan) for plan in plans), key=lambda offer: offer.rank)
    if not best.decides:
        return {"separates": _names(each), "what": NO_RUN}
    return {
        "separates": _names(best.decides),
        "what": f"{best.plan.text}, {best.repeats} x",
        "settings": best.plan.settings,
        "repeats": best.repeats,
        "odds": float(f"{math.exp(max(best.odds, -700.0)):.2g}"),
    }


def _offer(questions: Sequence[Question], plan: PlannedRun) -> Offer:
    """Planned runs with the number of repeats that decides most questions."""
    parts = [[p.contrast.products(plan.model) for p in q.pairs] for q in questions]
    offers, runs = [], plan.model.runs.runs
    for repeats in range(1, max(MOST_RUNS // runs, 1) + 1):
        made = [
            (q, q.promise(own, repeats, runs)) for q, own in zip(questions, parts, strict=True)
        ]
        kept = [(q, expected) for q, (expected, worst) in made if worst < EXCLUDED]
        odds = max((expected for _, expected in kept), default=0.0)
        offers.append(Offer(plan, repeats, tuple(q for q, _ in kept), odds))
        if len(kept) == len(questions):
            break
    return min(offers, key=lambda made: made.rank)


def _names(questions: Sequence[Question]) -> list[list[str]]:
    """Names of the found effects and of their rivals."""
    return [sorted(set(names)) for names in zip(*(q.names for q in questions), strict=True)]
