# SPDX-License-Identifier: Apache-2.0
"""When the next cycle is due. Pure; the wall clock is an argument."""

from __future__ import annotations

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
