# SPDX-License-Identifier: Apache-2.0
"""When the simulated bus makes its next cycle."""

from __future__ import annotations

PACES = ("realtime", "lockstep", "hold")

CATCH_UP = 25
"""A late real-time bus makes up for at most that many batches at once."""

IMPATIENT = 0.002
"""once an answer has not come, the next ones are waited for so long [s]"""


class Pacer:
    """Counts cycles against the wall clock (realtime), against the answers (lockstep), or not at
    all (hold).

    Wall times are arguments [s]. In lockstep an answer that does not come is waited for once for
    the whole time-out; from then on cycles follow each other quickly, so that bench time, and with
    it the rules on stale commands, goes on, until the answers are back.
    """

    def __init__(self, pace: str, batch: int, axes: frozenset[int], timeout: float) -> None:
        if pace not in PACES:
            raise ValueError(f"pace: unknown {pace!r}; choose one of {', '.join(PACES)}")
        self.pace = pace
        self.batch = batch
        self.axes = axes
        self.timeout = timeout
        self.cycle = -1
        self.until: int | None = None
        self.missing: set[int] = set()
        self.absent = False
        self.skipped = 0
        """batches that a realtime bus could not make in time and dropped from the wall clock"""
        self._last = 0.0
        self._start: float | None = None
        self._made = 0

    def set_pace(self, pace: str, wall: float) -> None:
        self.pace, self.until = pace, None
        self._start, self._made, self._last = wall, 0, wall

    def advance(self, cycle: int, cycles: int) -> int:
        """Let a held bus run in lockstep for `cycles` more; the last cycle of it.

        Whoever asks for less does not end what another has asked for.
        """
        self.pace = "lockstep"
        self.until = max(self.until or 0, cycle + cycles)
        return cycle + cycles

    def made(self, cycle: int, wall: float) -> None:
        """A batch that ends with `cycle` has gone out."""
        self.cycle, self._last = cycle, wall
        self._made += 1
        self.missing = set(self.axes)
        if self.until is not None and cycle >= self.until:
            self.pace, self.until = "hold", None

    def answered(self, axis: int, cycle: int) -> bool:
        """A command came; true when the next batch is due because of it."""
        if cycle != self.cycle:
            return False
        self.missing.discard(axis)
        if not self.missing:
            self.absent = False
        return self.free()

    def free(self) -> bool:
        """Whether lockstep waits for nobody."""
        return self.pace == "lockstep" and not self.missing

    def _may_still_come(self, wall: float) -> bool:
        patience = min(self.timeout, IMPATIENT) if self.absent else self.timeout
        return wall - self._last < patience

    def given_up(self, wall: float) -> bool:
        """Held, and the answers to the last cycle do not come: they are no longer waited for."""
        if self.pace != "hold" or not self.missing or self._may_still_come(wall):
            return False
        self.absent = True
        self.missing.clear()
        return True

    def due(self, wall: float, rate_hz: float) -> int:
        """Batches to make now, asked at every tick of the wall timer."""
        if self.pace == "lockstep":
            if self.free() and self.cycle >= 0:
                return 0
            if self._may_still_come(wall):
                return 0
            self.absent = self.cycle >= 0
            return 1
        if self.pace == "realtime":
            if self._start is None:
                self._start = wall
            behind = int((wall - self._start) * rate_hz / self.batch) - self._made
            if behind > CATCH_UP:
                self.skipped += behind - CATCH_UP
                self._made += behind - CATCH_UP
                behind = CATCH_UP
            return max(behind, 0)
        return 0
