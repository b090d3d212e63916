# SPDX-License-Identifier: Apache-2.0
"""Pacing of the simulated bus: decides when the next cycle is made."""

from __future__ import annotations

PACES = ("realtime", "lockstep", "hold")

CATCH_UP = 25
"""a late real-time bus makes up for at most this many batches at once"""

ABSENT_TIMEOUT_S = 0.002
"""wait for each further answer of a node that is not there, while cycles are asked for [s]"""


class Pacer:
    """Paces the cycles by the wall clock (realtime) or by the answers of the nodes (lockstep), or
    makes none (hold).

    Wall times are arguments [s]. In lockstep the bus waits for a missing answer as long as the
    node is there. A node that was started may have missed the present cycle: it is there from its
    first answer until a node leaves. For a node that is not there the bus waits once for the whole
    time-out, then only briefly, so that bench time goes on and the rules on stale commands act.
    """

    def __init__(self, pace: str, batch: int, axes: frozenset[int], timeout: float) -> None:
        if pace not in PACES:
            raise ValueError(f"pace: unknown {pace!r}; choose one of {', '.join(PACES)}")
        self.pace = pace
        self.batch = batch
        self.axes = axes
        self.timeout = timeout
        self.until: int | None = None
        """last cycle to make before the bus is held; None: no end"""
        self.missing: set[int] = set()
        """axes that have not answered the last batch"""
        self.absent = False
        """true when bench time went on without the answer of a node that is not there"""
        self._there: set[int] = set()
        """axes whose nodes have answered since one has left"""
        self.skipped = 0
        """batches that a real-time bus dropped because it was late"""
        self._last = 0.0
        self._start: float | None = None
        self._made = 0

    def set_pace(self, pace: str, wall: float) -> None:
        self.pace, self.until = pace, None
        self._start, self._made, self._last = None, 0, wall

    def advance(self, cycle: int, cycles: int) -> int:
        """Let a held bus run in lockstep for `cycles` more; returns the last of them.

        A shorter request does not cut a longer one of another client.
        """
        self.pace = "lockstep"
        self.until = max(self.until or 0, cycle + cycles)
        return cycle + cycles

    def register_batch(self, cycle: int, wall: float) -> None:
        """Register a batch that ends with `cycle` as sent."""
        self._last = wall
        self._made += 1
        self.missing = set(self.axes)
        if self.until is not None and cycle >= self.until:
            self.pace, self.until = "hold", None

    def register_answer(self, axis: int) -> bool:
        """Register an answer to the last batch; true when it makes the next batch due."""
        self.missing.discard(axis)
        self._there.add(axis)
        if not self.missing:
            self.absent = False
        return self.all_have_answered()

    def register_leaving(self) -> None:
        """Register that a node which answers has left, whichever."""
        self._there.clear()

    def all_have_answered(self) -> bool:
        """True when lockstep waits for no further answer."""
        return self.pace == "lockstep" and not self.missing

    def waited(self, wall: float) -> float:
        """Time for which an answer has been overdue [s]; 0: none is."""
        waited = wall - self._last
        lockstep = self.pace != "realtime" and self.missing
        return waited if lockstep and waited >= self.timeout else 0.0

    def _given_up(self, wall: float, period: float) -> bool:
        """True when an answer that is still missing does not come any more."""
        timeout = min(self.timeout, period) if self.absent else self.timeout
        return not self.axes <= self._there and wall - self._last >= timeout

    def stop_waiting(self, wall: float) -> bool:
        """True, once, when a held bus stops waiting for the answers to its last cycle."""
        held = self.pace == "hold" and bool(self.missing)
        if not (held and self._given_up(wall, ABSENT_TIMEOUT_S)):
            return False
        self.absent = True
        self.missing.clear()
        return True

    def batches_due(self, wall: float, rate_hz: float, *, idle: bool = False) -> int:
        """Number of batches to make now; called at every tick of the wall timer.

        `idle`: nothing moves and nobody waits for bench time, which then is not faster than the
        wall clock.
        """
        if self.pace == "lockstep":
            period = self.batch / rate_hz
            if self.all_have_answered():
                return int(not idle or wall - self._last >= period)
            if not self._given_up(wall, period if self.until is None else ABSENT_TIMEOUT_S):
                return 0
            self.absent = True
            return 1
        if self.pace == "realtime":
            if self._start is None:
                self._start = wall
            # to the nearest: a tick that is a little earlier than the first one was is no less
            behind = round((wall - self._start) * rate_hz / self.batch) - self._made
            if behind > CATCH_UP:
                self.skipped += behind - CATCH_UP
                self._made += behind - CATCH_UP
                behind = CATCH_UP
            return max(behind, 0)
        return 0
