# SPDX-License-Identifier: Apache-2.0
"""Requests to a core: each is answered at once and takes effect at a stated cycle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Answer(NamedTuple):
    """Accepted (from `cycle` on) or refused (with the reason; nothing has changed)."""

    accepted: bool
    reason: str
    cycle: int
    """first bus cycle that sees the effect; -1 when refused"""


def refused(reason: str) -> Answer:
    """A request that changes nothing."""
    return Answer(False, reason, -1)


class Agenda:
    """Accepted actions that wait for their cycle; the core calls `run` when `due` is not empty."""

    __slots__ = ("due", "last_cycle")

    def __init__(self) -> None:
        self.due: list[Callable[[], None]] = []
        self.last_cycle = -1

    def accept(self, action: Callable[[], None]) -> Answer:
        """Put an action down for the next cycle."""
        self.due.append(action)
        return Answer(True, "", self.last_cycle + 1)

    def run(self) -> None:
        """Do what is due, in the order in which it was accepted."""
        now, self.due = self.due, []
        for action in now:
            action()
