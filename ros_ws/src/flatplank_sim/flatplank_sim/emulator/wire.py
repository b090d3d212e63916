# SPDX-License-Identifier: Apache-2.0
"""The wire between master and segment, with losses and delays. Wall time is an argument."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

LATE_NS = 1_500_000
"""age of a frame from which its answer may come too late [ns]: the master waits for 2 ms"""


@dataclass
class Wire:
    """Passes frames on, with injected faults. Times are wall times [ns]."""

    max_age_ns: int = 5_000_000
    """largest age of a frame from the master; older ones are dropped: on a real wire none waits"""
    seed: int = 1
    lose_next: int = 0
    """number of process data frames to lose before they reach the slaves"""
    lose_answers: int = 0
    """number of process data answers to lose on their way back"""
    lose_share: float = 0.0
    """share of all frames that is lost"""
    delay_ns: int = 0
    """delay of the answers"""
    holding: bool = False
    """true: answers are held until they are released together"""
    down: bool = False
    """true: no frame passes"""
    counts: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ("received", "answered", "lost", "late", "aged", "process_data", "unanswered"), 0
        )
    )
    _held: list[bytearray] = field(default_factory=list)
    _waiting: list[tuple[int, bytearray]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)

    def admits(self, process_data: bool, age_ns: int) -> bool:
        """True when a frame from the master reaches the slaves."""
        self.counts["received"] += 1
        self.counts["process_data"] += process_data
        self.counts["late"] += age_ns > LATE_NS
        if age_ns > self.max_age_ns:
            self.counts["aged"] += 1
            return False
        if self.down or (self.lose_share and self._random.random() < self.lose_share):
            return self._lost()
        if process_data and self.lose_next > 0:
            self.lose_next -= 1
            return self._lost()
        return True

    def answer(self, frame: bytearray | None, process_data: bool, now: int) -> list[bytearray]:
        """Send an answer; returns the answers that reach the master at once."""
        if frame is None:
            self.counts["unanswered"] += 1
            return []
        if process_data and self.lose_answers > 0:
            self.lose_answers -= 1
            self._lost()
            return []
        if self.holding and process_data:
            self._held.append(frame)
            return []
        if self.delay_ns and process_data:
            self._waiting.append((now + self.delay_ns, frame))
            return []
        self.counts["answered"] += 1
        return [frame]

    def release(self) -> None:
        """Release the held answers together."""
        self.holding = False
        self._waiting = [(0, frame) for frame in self._held] + self._waiting
        self._held = []

    def due(self, now: int) -> list[bytearray]:
        """Delayed answers that are due."""
        if not self._waiting:
            return []
        out = [frame for at, frame in self._waiting if at <= now]
        self._waiting = [item for item in self._waiting if item[0] > now]
        self.counts["answered"] += len(out)
        return out

    @property
    def next_due(self) -> int | None:
        """Time when the next delayed answer is due [ns]; None: none."""
        return min((at for at, _ in self._waiting), default=None)

    def _lost(self) -> bool:
        self.counts["lost"] += 1
        return False
