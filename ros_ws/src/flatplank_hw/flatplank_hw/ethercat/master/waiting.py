# SPDX-License-Identifier: Apache-2.0
"""For an emulated bus: the next cycle waits until the nodes have answered the last one.

An emulated bus shares its computer with the nodes and with other work. What a machine would do
in a stall of the nodes is to stop; an emulated one stalls together with them, as long as they
live.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from flatplank_hw.bus.image import AxisCommand

LOOK_S = 0.05
"""so often a wait looks whether the bus shall end [s]"""
SHORTEST_NS = 10_000_000
"""the wait for somebody who is silent cycle after cycle [ns]"""


class Waiting:
    """Who has answered is waited for; who is silent for too long is waited for no more until it
    speaks."""

    def __init__(self, patience_s: float, batch: int = 1) -> None:
        """patience_s: longest wait for another answer, 0: none; batch: the last of so many cycles
        is answered."""
        self.patience_s = patience_s
        self.batch = batch
        self.waited_ns = 0
        """wall time beyond the period that answers took [ns]"""
        self.given_up = 0
        """waits that ended without an answer"""
        self._limit_ns = self._longest_ns = round(patience_s * 1e9)
        self._answered: dict[int, int] = {}

    def note(self, commands: Iterable[AxisCommand]) -> None:
        """Commands that have come."""
        for command in commands:
            self._answered[command.axis] = command.cycle

    def lacking(self, cycle: int) -> list[int]:
        """Axes whose answer `cycle`, the next one, must wait for."""
        return [axis for axis, last in self._answered.items() if last < cycle - self.batch]

    def hold(
        self,
        cycle: int,
        take: Callable[[float], list[AxisCommand]],
        go_on: Callable[[], bool],
    ) -> list[AxisCommand]:
        """Wait before `cycle`; what came, oldest first. `take(seconds)` gives what comes within
        that time."""
        found = take(0.0)
        self.note(found)
        if not self.patience_s or not self._answered:
            return found
        if not self.lacking(cycle):
            self._limit_ns = self._longest_ns
            return found
        start = now = time.perf_counter_ns()
        end = start + self._limit_ns
        while go_on() and self.lacking(cycle) and now < end:
            more = take(min(LOOK_S, (end - now) * 1e-9))
            self.note(more)
            found += more
            now = time.perf_counter_ns()
            if more:
                # somebody catches up, and shall
                end = now + self._limit_ns
        self.waited_ns += time.perf_counter_ns() - start
        self._conclude(self.lacking(cycle) if go_on() else [])
        return found

    def _conclude(self, silent: list[int]) -> None:
        """Who is silent cycle after cycle is waited for ever shorter, so that bench time goes on
        and the rules on old commands act."""
        self.given_up += len(silent)
        for axis in silent:
            del self._answered[axis]
        shorter = max(self._limit_ns // 2, SHORTEST_NS)
        self._limit_ns = shorter if silent else self._longest_ns
