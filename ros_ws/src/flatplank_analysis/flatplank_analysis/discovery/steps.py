# SPDX-License-Identifier: Apache-2.0
"""What a search has found: effects with their classes, its steps, and all of it together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from flatplank_analysis.discovery import heldout
from flatplank_analysis.discovery.decide import Decision
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import Model
from flatplank_analysis.discovery.rivals import Rival, Suspect
from flatplank_analysis.discovery.screen import Screen
from flatplank_analysis.discovery.state import State

LARGEST_CLASS = 4
"""names of an effect and its class together; more are no answer"""
Progress = Callable[[str, float], None]
"""what is done, and which share of it"""


@dataclass(frozen=True)
class Found:
    """An effect that was accepted."""

    decision: Decision
    suspects: tuple[Suspect, ...] = ()
    """effects that might stand in for it"""
    rivals: tuple[Rival, ...] = ()
    """the suspects once each was refitted in its place, the likeliest first"""

    @property
    def alike(self) -> tuple[str, ...]:
        """Its class: what the runs cannot tell from it."""
        return tuple(r.name for r in self.rivals if not r.excluded)

    @property
    def told(self) -> list[Rival]:
        """Its class as it is told: the likeliest ones. With more than these it is no answer."""
        return [r for r in self.rivals if not r.excluded][:LARGEST_CLASS]

    @property
    def weakly(self) -> tuple[str, ...]:
        """What can hardly be told from it."""
        return tuple(r.name for r in self.rivals if r.excluded and r.near)


@dataclass
class Step:
    """The state of the search after a number of accepted effects."""

    state: State
    screen: Screen
    found: list[Found]
    refits: list[Decision] = field(default_factory=list)
    """what was tried from here, best first"""

    @cached_property
    def held_out(self) -> float:
        """RMSE of the first channel in conditions that did not fix the sizes of the effects."""
        return heldout.rmse(self.state)


@dataclass
class Search:
    """All steps of a search; the last one is the result."""

    model: Model
    effects: list[type[Effect]]
    steps: list[Step]
    seconds: float
    looked_at: dict[str, int]
    """by effect: in how many ways it was looked for, times the number of effects"""
    base_fit: float
    """seconds that the first fit took"""
    first_ranking: float
    """seconds until the first ranking was there"""
    starts: int = 1
    """from how many tires the base was fitted"""
    polished: State | None = None
    """the end of the search with all pieces of the law set free: what they take is no fault"""

    @property
    def last(self) -> Step:
        return self.steps[-1]
