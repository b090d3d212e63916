# SPDX-License-Identifier: Apache-2.0
"""Decides when the next cycle starts, which answers it waits for, and which commands apply."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.cia402 import FAULT_RESET

CATCH_UP = 5
"""late cycles that are made up for; more are dropped and counted"""


class CycleClock:
    """Cycle n is due at start + n * period; a number is never used twice.

    After a stall the numbers jump with the wall clock, because the machine kept moving. With
    `slip` they continue without a gap, for an emulated bench, which stalls together with the
    master.
    """

    def __init__(self, period_ns: int, start_ns: int, slip: bool = False) -> None:
        self.period = period_ns
        self.slip = slip
        self.start = start_ns
        self.cycle = 0
        self.missed = 0
        """cycles that were dropped"""

    def due(self) -> int:
        """Wall time of the next cycle [ns]."""
        return self.start + (self.cycle + 1) * self.period

    def extend(self, waited_ns: int) -> None:
        """Shift the schedule by the time that the bus has waited for its nodes."""
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
"""a wait checks at this interval whether the bus is to end [s]"""
SHORTEST_NS = 10_000_000
"""shortest wait for nodes that stay silent [ns]"""
SHARE = 0.5
"""share of a cycle for the nodes' answers; a later answer makes the cycle longer [-]"""


class AnswerWait:
    """Lets a cycle of an emulated bus wait until the nodes have answered the cycle before.

    An emulated bus shares its computer with the nodes. When the nodes stall, a real machine would
    stop; the emulated bus stalls with them instead. It stops waiting for a node that is silent for
    too long, until that node answers again. On a slow computer bench time runs slower, so that
    recorder, panel and clients, which have lower priority, get computing time.
    """

    def __init__(self, node_timeout_s: float, batch: int = 1) -> None:
        """node_timeout_s: longest wait for a further answer, 0: none; batch: the nodes answer the
        last of this many cycles."""
        self.node_timeout_s = node_timeout_s
        self.batch = batch
        self.waited_ns = 0
        """wall time that late answers have added to the cycles [ns]"""
        self.given_up = 0
        """waits that ended without an answer"""
        self._limit_ns = self._longest_ns = round(node_timeout_s * 1e9)
        self._answered: dict[int, int] = {}

    def register_commands(self, commands: Iterable[AxisCommand]) -> None:
        """Register commands that have arrived."""
        for command in commands:
            self._answered[command.axis] = command.cycle

    def axes_without_answer(self, cycle: int) -> list[int]:
        """Axes for whose answer `cycle`, the next one, must wait."""
        return [axis for axis, last in self._answered.items() if last < cycle - self.batch]

    def wait_for_cycle(
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
        if not self.node_timeout_s:
            _sleep_until(due_ns)
            return take(0.0)
        found: list[AxisCommand] = []

        def hear(seconds: float) -> bool:
            """Receive commands for at most `seconds` [s]; true when some came."""
            more = take(seconds)
            self.register_commands(more)
            found.extend(more)
            return bool(more)

        _sleep_until(begun_ns + round(SHARE * (due_ns - begun_ns)))
        hear(0.0)
        start = due_ns
        if self.axes_without_answer(cycle):
            start = max(due_ns, self._late(cycle, begun_ns, due_ns, hear, go_on))
        elif self._answered:
            self._limit_ns = self._longest_ns
        _sleep_until(start)
        hear(0.0)
        self.waited_ns += start - due_ns
        return found

    def _late(
        self,
        cycle: int,
        begun_ns: int,
        due_ns: int,
        hear: Callable[[float], bool],
        go_on: Callable[[], bool],
    ) -> int:
        """Wait until all axes have answered; returns when the cycle may start [ns]."""
        now = time.perf_counter_ns()
        end = max(now, due_ns) + self._limit_ns
        while go_on() and self.axes_without_answer(cycle) and now < end:
            came = hear(min(LOOK_S, (end - now) * 1e-9))
            now = time.perf_counter_ns()
            if came:
                # a node catches up: give it the full time
                end = max(now, due_ns) + self._limit_ns
        silent = self.axes_without_answer(cycle) if go_on() else []
        self._conclude(silent)
        if silent or not go_on():
            return now
        return begun_ns + round(min(now - begun_ns, self._longest_ns) / SHARE)

    def _conclude(self, silent: list[int]) -> None:
        """Shorten the wait for nodes that stay silent, so that bench time goes on and the rules on
        stale commands act."""
        self.given_up += len(silent)
        for axis in silent:
            del self._answered[axis]
        shorter = max(self._limit_ns // 2, SHORTEST_NS)
        self._limit_ns = shorter if silent else self._longest_ns


def _sleep_until(then_ns: int) -> None:
    pause = then_ns - time.perf_counter_ns()
    if pause > 0:
        time.sleep(pause * 1e-9)


class CommandInbox:
    """Commands that arrived since the last cycle: the newest applies, but no fault reset is lost.
    A reset acts by its edge, which a newer command would overwrite before a drive sees it."""

    def __init__(self) -> None:
        self.current: dict[int, AxisCommand] = {}
        """command in force per axis"""
        self._later: dict[int, AxisCommand] = {}

    def commands_in_force(self, commands: Iterable[AxisCommand]) -> dict[int, AxisCommand]:
        """Commands that apply in this cycle."""
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
