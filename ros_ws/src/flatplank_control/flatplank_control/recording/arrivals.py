# SPDX-License-Identifier: Apache-2.0
"""How far the topics have been heard, against the stamps of the bus."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_control.recording.bus_cycles import TOPIC as BUS

BEHIND_NS = 500_000_000
"""whoever speaks at every cycle is never so far behind the bus"""


class Arrivals:
    """The latest stamp of every topic."""

    def __init__(self) -> None:
        self.bus_ns = 0
        """stamp of the last bus cycle [ns]"""
        self._last: dict[str, int] = {}

    def add(self, topic: str, stamp_ns: int) -> int:
        """A message came; returns its place in bench time [ns].

        Stamps that are not of the bench (diagnostics, by the wall clock) are put at the present
        cycle.
        """
        if topic == BUS:
            self.bus_ns = stamp_ns
        elif topic == "/diagnostics":
            return self.bus_ns
        self._last[topic] = stamp_ns
        return stamp_ns

    def behind(self, stamp_ns: int, topics: Iterable[str]) -> list[str]:
        """Those of some topics that speak at every cycle and were not heard up to a stamp: a
        message was lost on its way and comes again, or two nodes that have only just come do not
        hear each other yet. Without a stamp (0): not heard beside the bus.
        """
        wanted = stamp_ns or self.bus_ns - BEHIND_NS
        return [t for t in topics if self._last.get(t, -1) < wanted]
