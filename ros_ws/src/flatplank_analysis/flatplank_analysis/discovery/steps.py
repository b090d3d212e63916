# SPDX-License-Identifier: Apache-2.0
"""Results of a search: found effects with their classes, its steps, and the whole."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from flatplank_analysis.discovery import heldout, invariants
from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.screen import Screen, screen
from flatplank_analysis.discovery.state import State

LARGEST_CLASS = 4
"""most names of an effect and its class together; a larger class is no answer"""


@dataclass(frozen=True)
class Rival:
    """Another effect in the place of a found one, after its refit."""

    term: Term
    odds: float
    """against the found effect"""
    excluded: bool
    """True when it is too improbable for the class"""

    @property
    def name(self) -> str:
        return self.term.effect.identifier


@dataclass(frozen=True)
class AcceptedEffect:
    """An effect that was accepted."""

    decision: Decision
    rivals: tuple[Rival, ...] = ()
    """the likeliest first"""

    @property
    def alike(self) -> tuple[str, ...]:
        """Its class: effects that the runs cannot distinguish from it."""
        return tuple(r.name for r in self.rivals if not r.excluded)

    @property
    def reported(self) -> list[Rival]:
        """The likeliest members of its class. With the effect they are one name more than
        `LARGEST_CLASS` where the class is larger: programs see by it that there is no answer."""
        return [r for r in self.rivals if not r.excluded][:LARGEST_CLASS]

    @property
    def excluded_names(self) -> tuple[str, ...]:
        """The likeliest effects that the data exclude in its place."""
        return tuple(r.name for r in self.rivals if r.excluded)[: LARGEST_CLASS - 1]


@dataclass
class Step:
    """The state of the search after a number of accepted effects."""

    state: State
    ranking: Screen | None
    """of the candidates; None: made when `screen` is asked for"""
    found: list[AcceptedEffect]
    refits: list[Decision] = field(default_factory=list)
    """effects of the likeliest set that were not accepted"""

    @cached_property
    def screen(self) -> Screen:
        """All candidates, best first."""
        return screen(self.state) if self.ranking is None else self.ranking

    @cached_property
    def held_out(self) -> float:
        """Held-out RMSE of the first channel, see `heldout`."""
        return heldout.rmse(self.state)

    @cached_property
    def left(self) -> str:
        """The residual of consequence in words; empty when there is none."""
        return invariants.residual_of_consequence(self.state, bool(self.found))


@dataclass
class Search:
    """All steps of a search; the last one is the result."""

    model: Model
    effects: list[type[Effect]]
    steps: list[Step]
    seconds: float
    base_fit: float
    """duration of the first fit [s]"""
    first_ranking: float
    """time until the first ranking [s]"""
    starts: int = 1
    """number of sets of start values from which the base was fitted"""
    with_law_effects: State | None = None
    """the last state with all parts of the force law fitted: what they explain is no fault"""
    stated: dict[str, Any] = field(default_factory=dict)
    """probabilities of the sets of effects, see `inference.answer.to_dict`"""
    detectable: dict[str, tuple[float, str]] = field(default_factory=dict)
    """smallest size of each effect that is named, and its unit"""
    notes: tuple[str, ...] = ()
    """what the search itself has to say"""

    @property
    def last(self) -> Step:
        return self.steps[-1]
