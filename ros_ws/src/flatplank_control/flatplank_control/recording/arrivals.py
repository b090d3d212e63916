# SPDX-License-Identifier: Apache-2.0
"""Which topics have said their message of the present bus cycle."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_control.recording.bus_cycles import TOPIC as BUS

BEHIND_NS = 500_000_000
"""whoever speaks at every cycle is never so far behind the bus"""


class Arrivals:
    """Follows the stamps of the topics. A topic that spoke in the cycle before is expected in this
    one.
    """

    def __init__(self) -> None:
        self.bus_ns = 0
        """stamp of the last bus cycle [ns]"""
        self._before_ns = -1
        self._last: dict[str, int] = {}

    def add(self, topic: str, stamp_ns: int) -> int:
        """A message came; returns its place in bench time [ns].

        Stamps that are not of the bench (diagnostics, by the wall clock) are put at the present
        cycle.
        """
        if topic == BUS:
            self._before_ns, self.bus_ns = self.bus_ns, stamp_ns
        elif topic == "/diagnostics":
            return self.bus_ns
        self._last[topic] = stamp_ns
        return stamp_ns

    def complete(self, stamp_ns: int) -> bool:
        """The cycle of a stamp is in, and all that spoke in the cycle before have spoken."""
        if self.bus_ns < stamp_ns:
            return False
        return all(s != self._before_ns for t, s in self._last.items() if t != BUS)

    def silent(self, topics: Iterable[str]) -> list[str]:
        """Those of some topics that speak at every cycle and are not heard beside the bus: two
        nodes that have only just come hear each other at different times.
        """
        if not self.bus_ns:
            return []
        return [t for t in topics if self._last.get(t, -BEHIND_NS) < self.bus_ns - BEHIND_NS]
