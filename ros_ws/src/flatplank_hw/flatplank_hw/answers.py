# SPDX-License-Identifier: Apache-2.0
"""Requests to a core: the core answers each at once, and it takes effect at a stated cycle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Answer(NamedTuple):
    """Answer to a request: accepted, effective from `cycle` on, with what was done as `reason`;
    or refused, with the reason."""

    accepted: bool
    reason: str
    cycle: int
    """first bus cycle that sees the effect; -1 when refused"""


def refused(reason: str) -> Answer:
    """Return the answer to a refused request, which changes nothing."""
    return Answer(False, reason, -1)


class ActionQueue:
    """Queue of accepted actions; the core calls `run` in each cycle while `due` is not empty."""

    __slots__ = ("due", "last_cycle")

    def __init__(self) -> None:
        self.due: list[Callable[[], None]] = []
        self.last_cycle = -1

    def accept(self, action: Callable[[], None], done: str) -> Answer:
        """Schedule an action for the next cycle; `done` says what it does, with numbers."""
        self.due.append(action)
        cycle = self.last_cycle + 1
        return Answer(True, f"{done}, from cycle {cycle}", cycle)

    def run(self) -> None:
        """Perform the actions that are due, in the order in which they were accepted."""
        now, self.due = self.due, []
        for action in now:
            action()
