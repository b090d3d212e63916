# SPDX-License-Identifier: Apache-2.0
"""What the recorder reads of /bus/inputs: cycle numbers, stamps and the motion trigger.

Read out of the serialised message: at every cycle, beside all the writing.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct, error
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import RecordingError
from flatplank_data.run_record import RunRecord

TOPIC = "/bus/inputs"
TRIGGER_BIT = 1
_UINT = Struct("<I")
_STAMP = Struct("<iI")
_CYCLE = Struct("<QIB")
_ITEM_SIZES = (8, 8, 4, 4, 4, 4, 4)
"""[bytes] of the sequences before `digital`"""


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


def read_bus_image(cdr: bytes) -> BusImage:
    """Of a serialised flatplank_msgs/BusInputs (little endian); offsets count from byte 4."""
    try:
        seconds, nanoseconds = _STAMP.unpack_from(cdr, 4)
        at = 16 + _UINT.unpack_from(cdr, 12)[0]
        at = 4 + (at - 4 + 7 & ~7)
        cycle, period, count = _CYCLE.unpack_from(cdr, at)
        at += 14
        for size in _ITEM_SIZES:
            at = at + 3 & ~3
            length = _UINT.unpack_from(cdr, at)[0]
            at += 4
            if length:
                at = 4 + (at - 4 + size - 1 & ~(size - 1)) + length * size
        at = at + 3 & ~3
        digital = cdr[at + 4 : at + 4 + _UINT.unpack_from(cdr, at)[0]]
    except error:
        raise RecordingError(
            f"{TOPIC}: a message of {len(cdr)} bytes is not flatplank_msgs/BusInputs; "
            "build all packages from one version"
        ) from None
    trigger = any(bits & TRIGGER_BIT for bits in digital)
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
