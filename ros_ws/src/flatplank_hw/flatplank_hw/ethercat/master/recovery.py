# SPDX-License-Identifier: Apache-2.0
"""Which step to take when the bus is not well. Pure: health and time go in, a step comes out.

Tolerate, reopen the socket, acknowledge to OP, recover and reconfigure, scan everything anew. The
axes are stopped before anything beyond the socket is touched.
"""

from __future__ import annotations

from enum import IntEnum

from flatplank_hw.bus.image import Health

SETTLE_S = 0.3
"""time for the axes to stop before slaves are touched [s]"""
EFFECT_TIMEOUT_S = 0.25
"""time for a step to show its effect [s]"""
BACKOFF_S = 1.0
"""between full scans [s]"""
REOPEN_S = 0.02
"""between two new sockets [s]"""
ADDRESSED, SAFEOP = 0x0F, 4


class RecoveryStep(IntEnum):
    """Steps of the recovery."""

    NONE = 0
    REOPEN = 1
    ACKNOWLEDGE = 2
    RECONFIGURE = 3
    RESCAN = 4


class RecoveryPolicy:
    """Climbs while the bus is bad; steps down as soon as it is good."""

    def __init__(self) -> None:
        self.taken: dict[str, int] = {}
        """how often each step was taken"""
        self._bad_since: float | None = None
        self._last = -1e9
        self._step = RecoveryStep.NONE

    def step(
        self, now: float, health: Health, states: tuple[int, ...], silent: bool = False
    ) -> RecoveryStep:
        """now [s]; states: AL state of every slave that is not in OP (0: no answer); silent: no
        process data come back at all."""
        if health in (Health.OK, Health.DEGRADED):
            self._bad_since, self._step = None, RecoveryStep.NONE
            return RecoveryStep.NONE
        if self._bad_since is None:
            self._bad_since = now
        if health == Health.STALE:
            if now - self._last < REOPEN_S:
                return RecoveryStep.NONE
            self._take(RecoveryStep.REOPEN, now)
            self._step = RecoveryStep.NONE
            return RecoveryStep.REOPEN
        if now - self._bad_since < SETTLE_S:
            return RecoveryStep.NONE
        if silent and self._step < RecoveryStep.REOPEN:
            return self._take(RecoveryStep.REOPEN, now)
        if not states:
            return RecoveryStep.NONE
        wait = BACKOFF_S if self._step == RecoveryStep.RESCAN else EFFECT_TIMEOUT_S
        if self._step >= RecoveryStep.ACKNOWLEDGE and now - self._last < wait:
            return RecoveryStep.NONE
        return self._take(self._choose(states), now)

    def _choose(self, states: tuple[int, ...]) -> RecoveryStep:
        if all(s & ADDRESSED == SAFEOP for s in states) and self._step < RecoveryStep.ACKNOWLEDGE:
            return RecoveryStep.ACKNOWLEDGE
        if self._step < RecoveryStep.RECONFIGURE:
            return RecoveryStep.RECONFIGURE
        return RecoveryStep.RESCAN

    def _take(self, step: RecoveryStep, now: float) -> RecoveryStep:
        self._step, self._last = max(self._step, step), now
        self.taken[step.name] = self.taken.get(step.name, 0) + 1
        return step
