# SPDX-License-Identifier: Apache-2.0
"""Which step to take when the bus is not well. Pure: health and time go in, a rung comes out.

Tolerate, reopen the socket, acknowledge to OP, recover and reconfigure, scan everything anew. The
axes are stopped before anything beyond the socket is touched.
"""

from __future__ import annotations

from enum import IntEnum

from flatplank_hw.bus.image import Health

SETTLE_S = 0.3
"""time for the axes to stop before slaves are touched [s]"""
PATIENCE_S = 0.25
"""time for a rung to show its effect [s]"""
BACKOFF_S = 1.0
"""between full scans [s]"""
REOPEN_S = 0.02
"""between two new sockets [s]"""
ADDRESSED, SAFEOP = 0x0F, 4


class Rung(IntEnum):
    """Steps of the ladder."""

    NONE = 0
    REOPEN = 1
    ACKNOWLEDGE = 2
    RECONFIGURE = 3
    RESCAN = 4


class Ladder:
    """Climbs while the bus is bad; steps down as soon as it is good."""

    def __init__(self) -> None:
        self.taken: dict[str, int] = {}
        """how often each rung was taken"""
        self._bad_since: float | None = None
        self._last = -1e9
        self._rung = Rung.NONE

    def step(
        self, now: float, health: Health, states: tuple[int, ...], silent: bool = False
    ) -> Rung:
        """now [s]; states: AL state of every slave that is not in OP (0: no answer); silent: no
        process data come back at all."""
        if health in (Health.OK, Health.DEGRADED):
            self._bad_since, self._rung = None, Rung.NONE
            return Rung.NONE
        if self._bad_since is None:
            self._bad_since = now
        if health == Health.STALE:
            if now - self._last < REOPEN_S:
                return Rung.NONE
            self._take(Rung.REOPEN, now)
            self._rung = Rung.NONE
            return Rung.REOPEN
        if now - self._bad_since < SETTLE_S:
            return Rung.NONE
        if silent and self._rung < Rung.REOPEN:
            return self._take(Rung.REOPEN, now)
        if not states:
            return Rung.NONE
        wait = BACKOFF_S if self._rung == Rung.RESCAN else PATIENCE_S
        if self._rung >= Rung.ACKNOWLEDGE and now - self._last < wait:
            return Rung.NONE
        return self._take(self._choose(states), now)

    def _choose(self, states: tuple[int, ...]) -> Rung:
        if all(s & ADDRESSED == SAFEOP for s in states) and self._rung < Rung.ACKNOWLEDGE:
            return Rung.ACKNOWLEDGE
        if self._rung < Rung.RECONFIGURE:
            return Rung.RECONFIGURE
        return Rung.RESCAN

    def _take(self, rung: Rung, now: float) -> Rung:
        self._rung, self._last = max(self._rung, rung), now
        self.taken[rung.name] = self.taken.get(rung.name, 0) + 1
        return rung
