# SPDX-License-Identifier: Apache-2.0
"""What the recorder reads of /bus/inputs: cycle numbers and the motion trigger.

Read out of the serialised message: at every cycle, beside all the writing.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct, error
from typing import NamedTuple

import numpy as np

from flatplank_control.recording.errors import RecordingError
from flatplank_control.recording.run_record import RunRecord

TOPIC = "/bus/inputs"
TRIGGER_BIT = 1
_UINT = Struct("<I")
_CYCLE = Struct("<QIB")
_ITEM_SIZES = (8, 8, 4, 4, 4, 4, 4)
"""[bytes] of the sequences before `digital`"""


class BusImage(NamedTuple):
    """The cycles of one message."""

    first: int
    last: int
    trigger: bool
    """in any of them"""


def read_bus_image(cdr: bytes) -> BusImage:
    """Of a serialised flatplank_msgs/BusInputs (little endian); offsets count from byte 4."""
    try:
        at = 16 + _UINT.unpack_from(cdr, 12)[0]
        at = 4 + (at - 4 + 7 & ~7)
        cycle, _, count = _CYCLE.unpack_from(cdr, at)
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
    return BusImage(cycle - max(count, 1) + 1, cycle, any(bits & TRIGGER_BIT for bits in digital))


@dataclass
class CycleCount:
    """Counts bus cycles by their numbers."""

    first: int | None = None
    last: int | None = None
    received: int = 0
    lost: int = 0
    restarts: int = 0
    """times that the numbers went back: another bus took over"""

    def add_many(self, first: np.ndarray, last: np.ndarray) -> None:
        """Many messages at once: first and last cycle of each, [N]."""
        if not len(first):
            return
        first, last = np.asarray(first, np.int64), np.asarray(last, np.int64)
        self.add(BusImage(int(first[0]), int(last[0]), False))
        gaps = first[1:] - last[:-1] - 1
        self.lost += int(gaps[gaps > 0].sum())
        self.restarts += int((gaps < 0).sum())
        self.received += int((last[1:] - first[1:] + 1).sum())
        self.last = int(last[-1])

    def add(self, image: BusImage) -> None:
        if self.first is None or self.last is None:
            self.first = image.first
        elif image.first <= self.last:
            self.restarts += 1
        else:
            self.lost += image.first - self.last - 1
        self.last = image.last
        self.received += image.last - image.first + 1

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
