# SPDX-License-Identifier: Apache-2.0
"""Requests to a core: the core answers each at once, and it takes effect at a stated cycle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Answer(NamedTuple):
    """Answer to a request: accepted, effective from `cycle` on; or refused, with the reason."""

    accepted: bool
    reason: str
    cycle: int
    """first bus cycle that sees the effect; -1 when refused"""


def refused(reason: str) -> Answer:
    """A request that changes nothing."""
    return Answer(False, reason, -1)


class Agenda:
    """Queue of accepted actions; the core calls `run` in each cycle while `due` is not empty."""

    __slots__ = ("due", "last_cycle")

    def __init__(self) -> None:
        self.due: list[tuple[int, Callable[[], None]]] = []
        self.last_cycle = -1

    def accept(self, action: Callable[[], None], at_cycle: int | None = None) -> Answer:
        """Schedule an action for `at_cycle`, or for the next cycle; a past cycle is refused."""
        following = self.last_cycle + 1
        cycle = following if at_cycle is None else at_cycle
        if cycle < following:
            return refused(f"cycle {cycle} is over, the next one is {following}")
        self.due.append((cycle, action))
        return Answer(True, "", cycle)

    def run(self, cycle: int) -> None:
        """Perform the actions due at `cycle`, in the order in which they were accepted."""
        now = [action for at, action in self.due if at <= cycle]
        self.due = [item for item in self.due if item[0] > cycle]
        for action in now:
            action()
