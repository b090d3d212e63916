# SPDX-License-Identifier: Apache-2.0
"""Judges the start of a bench: which nodes are up, and when there is no sense in waiting on.

Waiting follows the nodes, not the clock. A node that loads its modules uses the processor or waits
for it or for the disk, however slowly; while one does, nobody gives up.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

STALL_TIMEOUT_S = 60.0
"""Longest time in which no node gets any further [s of wall clock]."""

RUNAWAY_CPU_S = 600.0
"""A node that has used so much processor and is not up does not come up [s]."""

NOTICED_CPU_S = 0.02
"""Processor time that counts as progress [s]; the clock tick of the kernel is 0.01 s."""


@dataclass(frozen=True)
class Vitals:
    """What the system says of a process that lives."""

    state: str
    """R, S, D, T ... as /proc/PID/stat has it"""
    cpu_s: float
    started: bool
    """its node is made and listens"""

    @property
    def waits_for_the_machine(self) -> bool:
        """It would go on at once if a processor or the disk were free."""
        return self.state in ("R", "D")


class Start:
    """The nodes of a start, what they have answered, and since when nothing has changed."""

    def __init__(self, names: Collection[str], now: float, stall_s: float = STALL_TIMEOUT_S):
        """`now`: wall clock [s], as in all methods."""
        self.up_at: dict[str, float] = {}
        """when the nodes that are up were first heard to be [s]"""
        self._lacks: dict[str, str | None] = dict.fromkeys(names)
        self._cpu = dict.fromkeys(names, 0.0)
        self._progress_at = now
        self._stall_s = stall_s

    def heard(self, name: str, lacks: str, now: float) -> None:
        """A node has answered: what it still waits for, empty when nothing."""
        if self._lacks[name] != lacks:
            self._lacks[name] = lacks
            self._progress_at = now
            if not lacks:
                self.up_at[name] = now

    @property
    def missing(self) -> list[str]:
        """Nodes that are not up."""
        return [name for name, lacks in self._lacks.items() if lacks != ""]

    def __str__(self) -> str:
        total = len(self._lacks)
        return f"{total - len(self.missing)} of {total} nodes are up"

    def hopeless(self, vitals: Mapping[str, Vitals], now: float) -> str:
        """Why waiting on makes no sense, empty while it does.

        `vitals`: of those nodes whose processes are known and live.
        """
        for name in self.missing:
            seen = vitals.get(name)
            if seen is None or seen.started:
                continue
            if seen.cpu_s > RUNAWAY_CPU_S:
                return f"{name}: not up after {seen.cpu_s:.0f} s of processor time; {self}"
            if seen.waits_for_the_machine or seen.cpu_s - self._cpu[name] >= NOTICED_CPU_S:
                self._cpu[name] = seen.cpu_s
                self._progress_at = now
        if now - self._progress_at <= self._stall_s:
            return ""
        hangs = "; ".join(self._hangs(name, vitals.get(name)) for name in self.missing[:3])
        return f"{hangs}; nothing has changed for {self._stall_s:.0f} s, {self}"

    def _hangs(self, name: str, seen: Vitals | None) -> str:
        lacks = self._lacks[name]
        if lacks:
            return f"{name} waits: {lacks}"
        return f"{name} {_why_silent(seen)}"


def _why_silent(seen: Vitals | None) -> str:
    if seen is None:
        return "does not answer; is the bench running?"
    if seen.started:
        return "runs, but its services are not heard"
    return "is stopped" if seen.state in "Tt" else "hangs before it is made, and uses no processor"
