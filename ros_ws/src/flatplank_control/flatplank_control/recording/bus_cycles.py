# SPDX-License-Identifier: Apache-2.0
"""Reads cycle numbers, stamps and motion trigger of /bus/inputs, and finds topics that lag behind.

It reads them from the serialised message, which is fast enough for every cycle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from flatplank_control.recording.typestore import message_definition
from flatplank_data.bags.cdr import MessageType, layout_of, parse_definition
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.run_record import RunRecord

TOPIC = "/bus/inputs"
DIAGNOSTICS = "/diagnostics"
TRIGGER_BIT = 1
_TYPE = "flatplank_msgs/msg/BusInputs"
_NUMBERS = ("header.stamp.sec", "header.stamp.nanosec", "cycle", "period_ns", "count")
_LAYOUTS: dict[int, _Places] = {}
"""size of a message [bytes] -> positions of its numbers; a bus usually has one size"""


class BusImage(NamedTuple):
    """Cycles of one message."""

    first: int
    last: int
    trigger: bool
    """true when any cycle has the trigger"""
    stamp_ns: int = 0
    """stamp of the last cycle [ns]"""
    period_ns: int = 0
    """period of the bus [ns]; 0: unknown"""


class _Places(NamedTuple):
    """Positions of the numbers in messages whose sequences have the same lengths."""

    lengths: tuple[tuple[slice, bytes], ...]
    numbers: tuple[slice, ...]
    digital: tuple[int, ...]


@lru_cache(maxsize=1)
def _kind() -> MessageType:
    return parse_definition(_TYPE, message_definition(_TYPE))


def _places(cdr: bytes) -> _Places:
    """Positions for messages like this one, from the definition of the type."""
    found = _LAYOUTS.get(len(cdr))
    if found is None or any(cdr[at] != value for at, value in found.lengths):
        try:
            layout = layout_of(_kind(), cdr)
        except FlatplankError:
            raise RecordingError(
                f"{TOPIC}: a message of {len(cdr)} bytes is not flatplank_msgs/BusInputs; "
                "build all packages from one version"
            ) from None
        lengths = (slice(at, at + 4) for at, _ in layout.lengths)
        numbers = (layout.members[name] for name in _NUMBERS)
        found = _LAYOUTS[len(cdr)] = _Places(
            tuple((at, cdr[at]) for at in lengths),
            tuple(slice(at, at + int(code[2])) for code, at in numbers),
            tuple(at for p, (_, at) in layout.members.items() if p.startswith("digital[")),
        )
    return found


def read_bus_image(cdr: bytes) -> BusImage:
    """Cycles of a serialised flatplank_msgs/BusInputs, little endian."""
    places = _places(cdr)
    seconds, nanoseconds, cycle, period, count = (
        int.from_bytes(cdr[at], "little") for at in places.numbers
    )
    trigger = any(cdr[at] & TRIGGER_BIT for at in places.digital)
    stamp_ns = seconds * 1_000_000_000 + nanoseconds
    return BusImage(cycle - max(count, 1) + 1, cycle, trigger, stamp_ns, period)


@dataclass
class CycleCount:
    """Counts lost bus cycles by numbers and by stamps, whichever shows more: a restarted bus
    counts from another number, and only the stamps show the pause.
    """

    first: int | None = None
    last: int | None = None
    stamp_ns: int = 0
    """stamp of the last cycle [ns]"""
    received: int = 0
    lost: int = 0
    restarts: int = 0
    """number of times that the cycle numbers went back, because the bus was restarted"""
    late: int | None = None
    """late cycles; None: the bus has not told of any, as without real time"""
    _told: int | None = None

    def tell_late(self, told: int) -> None:
        """Register what the bus tells of its late cycles: a count that begins anew with its
        pace."""
        if self._told is None:
            self.late = 0
        else:
            self.late = (self.late or 0) + (told - self._told if told >= self._told else told)
        self._told = told

    def add_many(
        self, first: np.ndarray, last: np.ndarray, stamps_ns: np.ndarray, period_ns: int
    ) -> None:
        """Add many messages at once: first cycle, last cycle and stamp of each, [N]."""
        if not len(first):
            return
        first, last = np.asarray(first, np.int64), np.asarray(last, np.int64)
        stamps = np.asarray(stamps_ns, np.int64)
        self.add(BusImage(int(first[0]), int(last[0]), False, int(stamps[0]), period_ns))
        made = last[1:] - first[1:] + 1
        gaps = first[1:] - last[:-1] - 1
        pauses = np.rint(np.diff(stamps) / period_ns).astype(int) - made if period_ns else gaps
        self.lost += int(np.maximum(np.maximum(gaps, pauses), 0).sum())
        self.restarts += int((gaps < 0).sum())
        self.received += int(made.sum())
        self.last, self.stamp_ns = int(last[-1]), int(stamps[-1])

    def add(self, image: BusImage) -> None:
        made = image.last - image.first + 1
        if self.first is None or self.last is None:
            self.first = image.first
        else:
            gap = image.first - self.last - 1
            self.restarts += gap < 0
            if image.period_ns:
                gap = max(gap, round((image.stamp_ns - self.stamp_ns) / image.period_ns) - made)
            self.lost += max(gap, 0)
        self.last, self.stamp_ns = image.last, image.stamp_ns
        self.received += made

    def with_bus_cycles(self, record: RunRecord) -> RunRecord:
        """The record with these numbers."""
        text = f"the bus restarted {self.restarts} times" if self.restarts else ""
        notes = record.notes
        if text not in notes:
            notes = f"{notes}; {text}" if notes else text
        return record.with_changes(
            cycle_first=self.first,
            cycle_last=self.last,
            cycles_received=self.received,
            cycles_lost=self.lost,
            cycles_late=self.late,
            notes=notes,
        )


BEHIND_NS = 500_000_000
"""largest lag of a topic that is published at every cycle [ns]"""


class BenchClock:
    """Bench time between the cycles of a bus in real time.

    The cycle that arrived with the least delay sets the clock: of the last `SET_NS`, because a bus
    that leaves cycles out falls behind, and its clock drifts from that of the computer.
    """

    SET_NS = 1_000_000_000

    def __init__(self) -> None:
        self._since = self._ahead = self._ahead_before = 0

    def add(self, stamp_ns: int, now_ns: int) -> None:
        """Register a cycle with its reception by the monotonic clock of the computer [ns]."""
        ahead = stamp_ns - now_ns
        if not self._since or abs(ahead - self._ahead) > self.SET_NS:  # the first, or a new bus
            self._since, self._ahead, self._ahead_before = now_ns, ahead, ahead
        elif now_ns - self._since > self.SET_NS:
            self._since, self._ahead_before, self._ahead = now_ns, self._ahead, ahead
        else:
            self._ahead = max(self._ahead, ahead)

    def time(self, now_ns: int) -> int:
        """Bench time [ns] at a time of the monotonic clock."""
        return now_ns + max(self._ahead, self._ahead_before)


class Arrivals:
    """Latest stamp of every topic, and the bench time of each reception."""

    def __init__(self) -> None:
        self.bus_ns = 0
        """stamp of the last bus cycle [ns]"""
        self.real_time = False
        """the bus tells of cycles by the wall clock; else bench time stands while a message is on
        its way"""
        self._clock = BenchClock()
        self._last: dict[str, int] = {}

    def received(self, topic: str, stamp_ns: int, now_ns: int) -> int:
        """Bench time at which a message of this bench time was received [ns]; `now_ns`: monotonic
        clock."""
        if topic == TOPIC:
            self._clock.add(stamp_ns, now_ns)
        return self._clock.time(now_ns) if self.real_time else stamp_ns

    def add(self, topic: str, stamp_ns: int) -> int:
        """Register a message; returns its bench time [ns].

        A stamp that may not be bench time (diagnostics of a node without a bus) is replaced by
        that of the present cycle.
        """
        if topic == TOPIC:
            self.bus_ns = stamp_ns
        elif topic == DIAGNOSTICS:
            return self.bus_ns
        self._last[topic] = stamp_ns
        return stamp_ns

    def behind(self, stamp_ns: int, topics: Iterable[str]) -> list[str]:
        """Topics among `topics`, published at every cycle, without a message up to the stamp: a
        lost message is sent again, or DDS has not connected two new nodes yet. With stamp 0:
        topics behind the bus.
        """
        wanted = stamp_ns or self.bus_ns - BEHIND_NS
        return [t for t in topics if self._last.get(t, -1) < wanted]
