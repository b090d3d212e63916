# SPDX-License-Identifier: Apache-2.0
"""When the next cycle is due, whose answer it waits for, and which commands hold in it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.cia402 import FAULT_RESET

CATCH_UP = 5
"""so many late cycles are made up for; more are given up and counted"""


class CycleClock:
    """Cycle n is due at start + n * period; a number is never used twice.

    After a stall the numbers jump with the wall clock, as the machine has gone on. With `slip`
    they go on without a gap instead: right for an emulated bench, which stalls together with the
    master.
    """

    def __init__(self, period_ns: int, start_ns: int, slip: bool = False) -> None:
        self.period = period_ns
        self.slip = slip
        self.start = start_ns
        self.cycle = 0
        self.missed = 0
        """cycles that were given up"""

    def due(self) -> int:
        """Wall time of the next cycle [ns]."""
        return self.start + (self.cycle + 1) * self.period

    def excuse(self, waited_ns: int) -> None:
        """Time in which the bus has waited for its nodes: nothing is late because of it."""
        self.start += waited_ns

    def advance(self, now_ns: int) -> int:
        """Begin the next cycle at wall time `now`; returns its number."""
        late = (now_ns - self.due()) // self.period
        if late > CATCH_UP:
            self.missed += late
            if self.slip:
                self.start += late * self.period
            else:
                self.cycle += late
        self.cycle += 1
        return self.cycle


LOOK_S = 0.05
"""so often a wait looks whether the bus shall end [s]"""
SHORTEST_NS = 10_000_000
"""the wait for somebody who is silent cycle after cycle [ns]"""
SHARE = 0.5
"""of a cycle that the nodes' answers may take; after a later one the cycle becomes longer"""


class Waiting:
    """For an emulated bus: the next cycle waits until the nodes have answered the last one.

    An emulated bus shares its computer with the nodes and with other work. A machine would stop
    in a stall of the nodes; an emulated one stalls together with them, as long as they live. A
    node that is silent for too long is waited for no more until it answers again. On a computer
    that is too slow for the nodes, bench time goes slower by itself, and recorder, panel and
    clients, which only listen and go behind the nodes, have their share of the computer.
    """

    def __init__(self, patience_s: float, batch: int = 1) -> None:
        """patience_s: longest wait for another answer, 0: none; batch: the last of so many cycles
        is answered."""
        self.patience_s = patience_s
        self.batch = batch
        self.waited_ns = 0
        """wall time by which late answers have made cycles longer than the period [ns]"""
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
        begun_ns: int,
        due_ns: int,
        take: Callable[[float], list[AxisCommand]],
        go_on: Callable[[], bool],
    ) -> list[AxisCommand]:
        """Wait until `cycle` may start: when it is due, or later.

        Args:
            cycle: number of the next cycle.
            begun_ns: when the last one began, by the performance counter [ns].
            due_ns: when the next one is due [ns].
            take: `take(seconds)` gives the commands that come within that time.
            go_on: false when the bus shall end.

        Returns:
            The commands that came, oldest first.
        """
        if not self.patience_s:
            _sleep_until(due_ns)
            return take(0.0)
        _sleep_until(begun_ns + round(SHARE * (due_ns - begun_ns)))
        found = take(0.0)
        self.note(found)
        start = due_ns
        if self.lacking(cycle):
            start = max(due_ns, self._late(cycle, begun_ns, due_ns, found, take, go_on))
        elif self._answered:
            self._limit_ns = self._longest_ns
        _sleep_until(start)
        more = take(0.0)
        self.note(more)
        self.waited_ns += start - due_ns
        return found + more

    def _late(
        self,
        cycle: int,
        begun_ns: int,
        due_ns: int,
        found: list[AxisCommand],
        take: Callable[[float], list[AxisCommand]],
        go_on: Callable[[], bool],
    ) -> int:
        """Add to `found` what comes until nobody lacks any more; the start that this allows."""
        now = time.perf_counter_ns()
        end = max(now, due_ns) + self._limit_ns
        while go_on() and self.lacking(cycle) and now < end:
            more = take(min(LOOK_S, (end - now) * 1e-9))
            self.note(more)
            found += more
            now = time.perf_counter_ns()
            if more:
                # somebody catches up, and shall
                end = max(now, due_ns) + self._limit_ns
        silent = self.lacking(cycle) if go_on() else []
        self._conclude(silent)
        if silent or not go_on():
            return now
        return begun_ns + round(min(now - begun_ns, self._longest_ns) / SHARE)

    def _conclude(self, silent: list[int]) -> None:
        """Who is silent cycle after cycle is waited for ever shorter, so that bench time goes on
        and the rules on old commands act."""
        self.given_up += len(silent)
        for axis in silent:
            del self._answered[axis]
        shorter = max(self._limit_ns // 2, SHORTEST_NS)
        self._limit_ns = shorter if silent else self._longest_ns


def _sleep_until(then_ns: int) -> None:
    pause = then_ns - time.perf_counter_ns()
    if pause > 0:
        time.sleep(pause * 1e-9)


class Inbox:
    """Commands that arrived since the last cycle: the newest counts, but no fault reset gets lost.
    It acts by its edge, and in a burst it would be overwritten before any drive saw it."""

    def __init__(self) -> None:
        self.current: dict[int, AxisCommand] = {}
        """command in force per axis"""
        self._later: dict[int, AxisCommand] = {}

    def take(self, commands: Iterable[AxisCommand]) -> dict[int, AxisCommand]:
        """What holds in this cycle."""
        waiting, self._later = self._later, {}
        shown: set[int] = set()
        for command in (*waiting.values(), *commands):
            axis = command.axis
            if axis in shown:
                self._later[axis] = command
                continue
            before = self.current.get(axis)
            self.current[axis] = command
            starts = command.control_word & FAULT_RESET
            if starts and not (before is not None and before.control_word & FAULT_RESET):
                shown.add(axis)
        return self.current
