# SPDX-License-Identifier: Apache-2.0
"""Determines the health of the bus and the recovery step from the observed cycles and the time.

Order of recovery: tolerate, reopen the socket, acknowledge to OP, recover and reconfigure, scan
the whole bus. The axes are stopped before any step after reopening the socket.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

from flatplank_hw.bus.image import Health

TOLERATED = 2
"""bad cycles in a row that are only counted"""


class CycleObservation(NamedTuple):
    """Observation of one cycle on the wire."""

    arrived: bool
    counter: int
    """working counter"""
    echo_ok: bool


class SlaveState(NamedTuple):
    """AL state of one slave as last read; state 0 means no answer."""

    name: str
    state: int
    code: int
    text: str


OPERATIONAL = 8


@dataclass
class HealthMonitor:
    """Counts good and bad cycles and determines the health of the bus."""

    expected: int
    sent: int = 0
    received: int = 0
    lost: int = 0
    wrong_counter: int = 0
    stale: int = 0
    in_a_row: int = 0
    faulty: tuple[SlaveState, ...] = ()
    """slaves that were not in OP at the last check"""
    link: str = ""
    """fault of the interface at the last check; empty: none"""
    reason: str = ""
    history: dict[str, int] = field(default_factory=dict)
    """health -> number of cycles"""

    def observe(self, seen: CycleObservation) -> Health:
        """Health after one more cycle."""
        self.sent += 1
        good = seen.arrived and seen.counter == self.expected
        if seen.arrived:
            self.received += 1
        else:
            self.lost += 1
        if seen.arrived and not good:
            self.wrong_counter += 1
        self.in_a_row = 0 if good else self.in_a_row + 1
        verdict = self._verdict(seen)
        self.history[verdict.name] = self.history.get(verdict.name, 0) + 1
        return verdict

    def register_states(self, states: tuple[SlaveState, ...]) -> None:
        """Register the AL states of the slaves."""
        self.faulty = tuple(s for s in states if s.state != OPERATIONAL)

    @property
    def states_in_doubt(self) -> bool:
        """True when the AL states should be read now."""
        return self.in_a_row > 0

    def _verdict(self, seen: CycleObservation) -> Health:
        if seen.arrived and not seen.echo_ok:
            self.stale += 1
            self.reason = "answers belong to an older cycle"
            return Health.STALE
        if self.in_a_row > TOLERATED:
            self.reason = (
                f"working counter {seen.counter} of {self.expected}"
                if seen.arrived
                else f"no answer for {self.in_a_row} cycles"
            )
            if self.link and not seen.arrived:
                self.reason += f"; {self.link}"
            if self.faulty:
                self.reason += "; " + describe_slaves(self.faulty)
            return Health.LOST
        if self.faulty:
            self.reason = describe_slaves(self.faulty)
            return Health.SLAVE_FAULT
        if self.in_a_row:
            return Health.DEGRADED
        self.reason = ""
        return Health.OK


_STATES = {0: "no answer", 1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP"}


def describe_slaves(states: tuple[SlaveState, ...]) -> str:
    """Text with slaves, their states and codes."""
    parts = []
    for s in states:
        text = _STATES.get(s.state & 0x0F, hex(s.state))
        if s.state & 0x10:
            text += f" with error 0x{s.code:04X} ({s.text})"
        parts.append(f"{s.name}: {text}")
    return ", ".join(parts)


SETTLE_S = 0.3
"""time for the axes to stop before slaves are reconfigured [s]"""
EFFECT_TIMEOUT_S = 0.25
"""time to wait for the effect of a step [s]"""
BACKOFF_S = 1.0
"""time between full scans [s]"""
REOPEN_S = 0.02
"""time between two reopenings of the socket [s]"""
ADDRESSED, SAFEOP = 0x0F, 4


class RecoveryStep(IntEnum):
    """Steps of the recovery, in increasing order of intervention."""

    NONE = 0
    REOPEN = 1
    ACKNOWLEDGE = 2
    RECONFIGURE = 3
    RESCAN = 4


class RecoveryPolicy:
    """Takes stronger steps while the bus is bad; starts over once it is good."""

    def __init__(self) -> None:
        self.taken: dict[str, int] = {}
        """step -> number of times taken"""
        self._bad_since: float | None = None
        self._last = -1e9
        self._step = RecoveryStep.NONE

    def step(
        self, now: float, health: Health, states: tuple[int, ...], silent: bool = False
    ) -> RecoveryStep:
        """Step to take at time `now` [s]. states: AL state of each slave that is not in OP (0: no
        answer); silent: no process data are received at all."""
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
