# SPDX-License-Identifier: Apache-2.0
"""Cycle numbers, stamps and the motion trigger of /bus/inputs, and how far other topics lag
behind.

Read out of the serialised message: at every cycle, beside all the writing."""

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
TRIGGER_BIT = 1
_TYPE = "flatplank_msgs/msg/BusInputs"
_NUMBERS = ("header.stamp.sec", "header.stamp.nanosec", "cycle", "period_ns", "count")
_LAYOUTS: dict[int, _Places] = {}
"""bytes of a message -> where its numbers lie; a bus hardly has more than one"""


class BusImage(NamedTuple):
    """The cycles of one message."""

    first: int
    last: int
    trigger: bool
    """in any of them"""
    stamp_ns: int = 0
    """of the last one [ns]"""
    period_ns: int = 0
    """of the bus; 0: it does not say [ns]"""


class _Places(NamedTuple):
    """Slices of the bytes of messages whose sequences have the same lengths."""

    lengths: tuple[tuple[slice, bytes], ...]
    numbers: tuple[slice, ...]
    digital: tuple[int, ...]


@lru_cache(maxsize=1)
def _kind() -> MessageType:
    return parse_definition(_TYPE, message_definition(_TYPE))


def _places(cdr: bytes) -> _Places:
    """Of a message like this one, from the definition of its type."""
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
    """Of a serialised flatplank_msgs/BusInputs, little endian."""
    places = _places(cdr)
    seconds, nanoseconds, cycle, period, count = (
        int.from_bytes(cdr[at], "little") for at in places.numbers
    )
    trigger = any(cdr[at] & TRIGGER_BIT for at in places.digital)
    stamp_ns = seconds * 1_000_000_000 + nanoseconds
    return BusImage(cycle - max(count, 1) + 1, cycle, trigger, stamp_ns, period)


@dataclass
class CycleCount:
    """Counts bus cycles by their numbers and by their stamps, whichever shows more gaps: a bus
    that was started anew counts from another number, and its pause is in the stamps only.
    """

    first: int | None = None
    last: int | None = None
    stamp_ns: int = 0
    """of the last cycle [ns]"""
    received: int = 0
    lost: int = 0
    restarts: int = 0
    """times that the numbers went back: another bus took over"""

    def add_many(
        self, first: np.ndarray, last: np.ndarray, stamps_ns: np.ndarray, period_ns: int
    ) -> None:
        """Many messages at once: first and last cycle and stamp of each, [N]."""
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

    def told_in(self, record: RunRecord) -> RunRecord:
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
            notes=notes,
        )


BEHIND_NS = 500_000_000
"""a topic that is published at every cycle is never so far behind the bus"""


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
        if topic == TOPIC:
            self.bus_ns = stamp_ns
        elif topic == "/diagnostics":
            return self.bus_ns
        self._last[topic] = stamp_ns
        return stamp_ns

    def behind(self, stamp_ns: int, topics: Iterable[str]) -> list[str]:
        """Those of some topics, published at every cycle, that have not come up to a stamp: a
        message was lost and comes again, or two nodes that have just started have not found each
        other yet. Without a stamp (0): that are behind the bus.
        """
        wanted = stamp_ns or self.bus_ns - BEHIND_NS
        return [t for t in topics if self._last.get(t, -1) < wanted]
