# SPDX-License-Identifier: Apache-2.0
"""Finds the messages of an MCAP chunk: by its index where that is whole, else record by record."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatplank_data.bags.blocks import Block, Channel
from flatplank_data.bags.mcap_records import HEAD, MESSAGE, MESSAGE_HEAD, Channels, records
from flatplank_data.guard import DamagedError

_BOTH = HEAD + MESSAGE_HEAD


@dataclass(frozen=True)
class Messages:
    """Heads of the messages in a buffer, arrays of shape (messages,)."""

    buffer: np.ndarray
    start: np.ndarray
    """where each payload begins [bytes]"""
    size: np.ndarray
    """of each payload [bytes]"""
    channel: np.ndarray
    time: np.ndarray
    """log time [ns]"""

    def blocks(self, number: int, channel: Channel) -> Iterator[Block]:
        """The messages of one channel."""
        ours = self.channel == number
        for size in np.unique(self.size[ours]):
            same = ours & (self.size == size)
            payloads = _windows(self.buffer, self.start[same], int(size))
            yield Block(channel, self.time[same], payloads)


def read_index(record: bytes) -> np.ndarray:
    """Offsets of the messages in an index record; empty when the record is damaged."""
    if len(record) < 6 or struct.unpack_from("<I", record, 2)[0] != len(record) - 6:
        return np.empty(0, dtype=np.int64)
    entries = np.frombuffer(record[6 : len(record) - (len(record) - 6) % 16], dtype="<u8")
    return entries[1::2].astype(np.int64)


def messages_at(buffer: np.ndarray, offsets: np.ndarray) -> Messages:
    """The messages whose records begin at `offsets` [bytes]. Raises DamagedError."""
    if offsets.size and not 0 <= offsets.min() <= offsets.max() <= buffer.size - _BOTH:
        raise DamagedError("a message is cut short")
    heads = _windows(buffer, offsets, _BOTH)
    size = _column(heads, 1, "<u8") - MESSAGE_HEAD
    start = offsets + _BOTH
    if (heads[:, 0] != MESSAGE).any() or (size < 0).any() or (size > buffer.size - start).any():
        raise DamagedError("a message is cut short")
    number, time = _column(heads, HEAD, "<u2"), _column(heads, HEAD + 6, "<u8")
    return Messages(buffer, start, size, number, time)


def messages_of_chunk(buffer: np.ndarray, offsets: np.ndarray) -> Messages | None:
    """All messages by the offsets of an index; None when they are not the whole chunk."""
    try:
        found = messages_at(buffer, np.sort(offsets))
    except DamagedError:
        return None
    ends = np.append(0, found.start + found.size)
    whole = np.array_equal(ends[:-1], found.start - _BOTH) and ends[-1] == buffer.size
    return found if whole else None


def scan(buffer: np.ndarray, channels: Channels, torn: bool = False) -> Messages:
    """The messages record by record; schemas and channels go to `channels`.

    torn: the last record may be cut short. Raises DamagedError.
    """
    data, offsets = buffer.tobytes(), []
    try:
        for record in records(data, 0, len(data)):
            if record.opcode == MESSAGE:
                offsets.append(record.start - HEAD)
            else:
                channels.add(record.opcode, data[record.start : record.end])
    except DamagedError:
        if not torn:
            raise
    return messages_at(buffer, np.array(offsets, dtype=np.int64))


def _column(heads: np.ndarray, at: int, kind: str) -> np.ndarray:
    width = np.dtype(kind).itemsize
    return np.ascontiguousarray(heads[:, at : at + width]).view(kind)[:, 0].astype(np.int64)


def _windows(buffer: np.ndarray, offsets: np.ndarray, size: int) -> np.ndarray:
    """Rows of `size` bytes from each offset, shape (offsets, size)."""
    if not offsets.size or not size:
        return np.empty((offsets.size, size), dtype=np.uint8)
    return np.lib.stride_tricks.sliding_window_view(buffer, size)[offsets]
