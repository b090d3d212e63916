# SPDX-License-Identifier: Apache-2.0
"""The planned run after which the data tell the effects of a class apart.

A prediction counts as a verdict does: in units of the noise, with the scatter of the tire from run
to run, after everything else is fitted again to old and new runs together, and against the
difference that does not decide (`rivals.indecisive_difference`), which grows with the runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from scipy.stats import norm

from flatplank_analysis.discovery.contrast import Contrast, Products
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.rivals import Rival, indecisive_difference
from flatplank_analysis.discovery.steps import Search

MOST_RUNS = 30
"""most runs of a proposal: those of a usual campaign"""
KEPT = float(norm.ppf(0.95))
"""standard deviations by which an expected difference exceeds what decides: the noise of the new
runs breaks one promise in twenty"""
CLEAR = 2.0
"""factor on the difference that decides: runs that would exceed it only barely are not proposed,
because there the form of the models decides, not the machine"""
NO_RUN = "none of the planned runs tells these apart; check on the machine"


class PlannedRun(Protocol):
    """A run that the bench can make."""

    @property
    def text(self) -> str: ...

    @property
    def settings(self) -> dict[str, Any]: ...

    @property
    def model(self) -> Model: ...


@dataclass(frozen=True)
class Promise:
    """What a number of equal planned runs is expected to do for one pair."""

    expected: float
    """whitened sum of squares by which the rival explains less, in all runs"""
    needed: float
    """least value that excludes the rival"""
    chance: float
    """by how much less it may be by the noise of the new runs"""

    @property
    def margin(self) -> float:
        """Sure part of what is expected, as a share of what is needed."""
        return (self.expected - self.chance) / self.needed

    @property
    def kept(self) -> bool:
        return self.margin > CLEAR


def next_run(search: Search, plans: Sequence[PlannedRun]) -> dict[str, Any]:
    """The planned run that with the fewest repeats excludes the rivals of most indistinguishable
    pairs, as the JSON of a diagnosis has it; {} without such pairs."""
    found = search.last.found
    pairs = [(i, r) for i, f in enumerate(found) for r in f.rivals if not r.excluded]
    if not pairs or not plans:
        return {}
    each = [Question(search, i, rival) for i, rival in pairs]
    best = min((_offer(each, plan) for plan in plans), key=lambda offer: offer.rank)
    if not best.decides:
        return {"separates": _names(each), "what": NO_RUN}
    return {
        "separates": _names(best.decides),
        "what": f"{best.plan.text}, {best.repeats} x",
        "settings": best.plan.settings,
        "repeats": best.repeats,
        "expected": float(f"{best.least.expected:.3g}"),
        "needed": float(f"{best.least.needed:.3g}"),
    }


class Question:
    """Whether planned runs would exclude a rival of a found effect."""

    def __init__(self, search: Search, index: int, rival: Rival) -> None:
        self.decisions = [f.decision for f in search.last.found]
        self.index, self.rival = index, rival
        self.apart = Contrast.of(search, index, rival.term)
        self.drop = Contrast.of(search, index, None)

    @property
    def names(self) -> tuple[str, str]:
        """Found effect and rival."""
        return self.decisions[self.index].term.effect.identifier, self.rival.name

    def products(self, planned: Model) -> tuple[Products, Products]:
        """What one run adds to the difference from the rival, and to the drop."""
        return self.apart.products(planned), self.drop.products(planned)

    def promise(self, apart: Products, drop: Products, repeats: int) -> Promise:
        """What `repeats` such runs are expected to do."""
        (more,) = self.apart.gain(apart.times(repeats))
        after = list(self.decisions)
        own = after[self.index]
        (grown,) = own.drop + self.drop.gain(drop.times(repeats))
        after[self.index] = replace(own, drop=float(grown))
        # a log likelihood ratio varies by twice its root; the dispersion is that of the noise
        chance = 2.0 * KEPT * float(np.sqrt(more * max(own.dispersion, 1.0)))
        needed = indecisive_difference(after[self.index], after)
        return Promise(float(self.rival.excess + more), float(needed), chance)


@dataclass(frozen=True)
class Offer:
    """A planned run with the number of repeats at which it decides most pairs."""

    plan: PlannedRun
    repeats: int
    decides: tuple[Question, ...]
    promises: tuple[Promise, ...]
    """for the pairs that it decides"""

    @property
    def least(self) -> Promise:
        """The promise with the least margin."""
        return min(self.promises, key=lambda p: p.margin)

    @property
    def rank(self) -> tuple[int, float, float]:
        """The best offer has the least rank: of those that decide most, the shortest."""
        margin = self.least.margin if self.promises else 0.0
        time = float(self.plan.model.runs.time[:, -1].sum())
        return -len(self.decides), self.repeats * time, -margin


def _offer(questions: Sequence[Question], plan: PlannedRun) -> Offer:
    """Planned runs with the number of repeats that decides most pairs."""
    products = [q.products(plan.model) for q in questions]

    def offer(repeats: int) -> Offer:
        made = [(q, q.promise(*p, repeats)) for q, p in zip(questions, products, strict=True)]
        kept = [(q, promise) for q, promise in made if promise.kept]
        decides, promises = zip(*kept, strict=True) if kept else ((), ())
        return Offer(plan, repeats, decides, promises)

    most = max(MOST_RUNS // plan.model.runs.runs, 1)
    # more runs do not always decide more: what does not decide grows with them
    return min(map(offer, range(1, most + 1)), key=lambda made: made.rank)


def _names(questions: Sequence[Question]) -> list[list[str]]:
    """Names of the found effects and of their rivals."""
    return [sorted(set(names)) for names in zip(*(q.names for q in questions), strict=True)]
