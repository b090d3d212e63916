# SPDX-License-Identifier: Apache-2.0
"""Reads MCAP files as blocks of messages; what is damaged is left out and told.

The file is read from front to back, so a truncated file can be read, too. A chunk whose checksum
is wrong is left out. Behind a damaged record the reading goes on at the next chunk of the summary.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flatplank_data.bags.blocks import Block
from flatplank_data.bags.mcap_index import (
    Messages,
    messages_at,
    messages_of_chunk,
    read_index,
    scan,
)
from flatplank_data.bags.mcap_records import (
    CHUNK,
    DATA_END,
    HEAD,
    INDEX,
    MAGIC,
    MESSAGE,
    Record,
    Summary,
    read_summary,
    records,
    torn_chunk,
    unpack_chunk,
)
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget, DamagedError

NO_END = "the bag has no end (recorder killed?): read as far as it goes"
COPY = "copy the bag again from where it was recorded"
_GAP, _TORN = 0, -1
"""stand for opcodes: damaged bytes, and a chunk without its end"""
_NAMED = 3
"""number of damaged parts that are named one by one"""


@dataclass
class Lost:
    """Damaged parts of a file, between the log times of the messages around them [ns]."""

    parts: list[list[float]] = field(default_factory=list)
    first: float = np.nan
    last: float = np.nan
    why: str = ""
    _open: bool = False

    def begin(self, why: str) -> None:
        """Something is damaged here."""
        self.why = self.why or why
        if not self._open:
            self.parts.append([self.last, np.nan])
        self._open = True

    def seen(self, times: np.ndarray) -> None:
        """Good messages follow."""
        if not times.size:
            return
        if self._open:
            self.parts[-1][1] = float(times.min())
            self._open = False
        self.first = float(np.fmin(self.first, times.min()))
        self.last = float(np.fmax(self.last, times.max()))

    def __str__(self) -> str:
        named = []
        for begin, end in self.parts[:_NAMED]:
            a, b = (1e-9 * (t - self.first) for t in (begin, end))
            low = "the start" if np.isnan(a) else f"{a:.3f} s"
            named.append(f"{low} to " + ("the end" if np.isnan(b) else f"{b:.3f} s"))
        more = len(self.parts) - _NAMED
        text = ", ".join(named) + (f" and {more} more" if more > 0 else "")
        return f"damaged ({self.why}): the messages from {text} are left out; {COPY}"


class McapFile:
    """One .mcap file; `remarks` tells what was left out, once its blocks were read."""

    def __init__(self, path: Path, budget: Budget | None = None) -> None:
        self.path = path
        self.remarks: list[str] = []
        self.budget = budget or Budget.of(path.name, path.stat().st_size)
        self._lost = Lost()
        self._proven = True
        self._unknown = 0

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics, chunk by chunk. Raises FlatplankError."""
        with open(self.path, "rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                what = "not an MCAP file, or empty"
                raise FlatplankError(what, self.path.name, "start the recorder again to repair it")
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                summary = read_summary(data)
                self._channels = summary.channels
                for messages in self._messages(data, summary):
                    yield from self._select(messages, wanted)

    def _messages(self, data: mmap.mmap, summary: Summary) -> Iterator[Messages]:
        chunk: Record | None = None
        index: list[np.ndarray] = []
        loose: list[int] = []
        end: Record | None = None
        for record in self._records(data, summary):
            content = data[record.start : record.end]
            if record.opcode == INDEX:
                index.append(read_index(content))
                continue
            if chunk is not None:
                yield from self._chunk(data[chunk.start : chunk.end], index)
            chunk, index = (record if record.opcode == CHUNK else None), []
            if record.opcode == _GAP:
                self._lost.begin("wrong length of a record")
            elif record.opcode == MESSAGE:
                loose.append(record.start - HEAD)
            elif record.opcode == _TORN:
                yield from self._torn(content)
            elif record.opcode == DATA_END:
                end = record
            else:
                self._describe(record.opcode, content)
        if chunk is not None:
            yield from self._chunk(data[chunk.start : chunk.end], index)
        if loose:
            self._proven = False
            buffer = np.frombuffer(data[:], dtype=np.uint8)
            yield from self._good(messages_at(buffer, np.array(loose)))
        self._tell(data, summary, end)

    def _records(self, data: mmap.mmap, summary: Summary) -> Iterator[Record]:
        """The records up to the end of the data; goes on behind damaged ones."""
        at, end, whole = len(MAGIC), len(data), data[-len(MAGIC) :] == MAGIC
        while True:
            try:
                for record in records(data, at, end):
                    yield record
                    at = record.end
                    if record.opcode == DATA_END:
                        return
                whole = False
            except DamagedError:
                pass
            following = next((start for start in summary.chunks if start > at), None)
            if following is None:
                break
            yield Record(_GAP, at, at)
            at = following
        if whole:
            yield Record(_GAP, at, at)
            return
        self.remarks.append(NO_END)
        if data[at : at + 1] == bytes([CHUNK]):
            yield Record(_TORN, min(at + HEAD, end), end)

    def _chunk(self, record: bytes, index: list[np.ndarray]) -> Iterator[Messages]:
        """Messages of a chunk; none when it is damaged."""
        try:
            buffer, proven = unpack_chunk(record, self.budget)
            self._proven &= proven
            found = messages_of_chunk(buffer, np.concatenate(index)) if index else None
            if found is None:
                found = scan(buffer, self._channels)
        except DamagedError as error:
            self._lost.begin(str(error))
            return
        yield from self._good(found)

    def _torn(self, record: bytes) -> Iterator[Messages]:
        """The whole messages of a chunk that has lost its end."""
        self._proven = False
        try:
            yield from self._good(scan(torn_chunk(record), self._channels, torn=True))
        except DamagedError as error:
            self._lost.begin(str(error))

    def _good(self, found: Messages) -> Iterator[Messages]:
        self._lost.seen(found.time)
        yield found

    def _describe(self, opcode: int, content: bytes) -> None:
        """Register a schema or channel outside of the chunks."""
        try:
            if self._channels.add(opcode, content):
                self._proven = False
        except DamagedError as error:
            self._lost.begin(str(error))

    def _select(self, messages: Messages, wanted: set[str]) -> Iterator[Block]:
        for number in np.unique(messages.channel):
            channel = self._channels.by_number.get(int(number))
            if channel is None:
                self._unknown += int((messages.channel == number).sum())
            elif channel.topic in wanted:
                yield from messages.blocks(int(number), channel)

    def _tell(self, data: mmap.mmap, summary: Summary, end: Record | None) -> None:
        """Remarks; raises FlatplankError when samples may be wrong and nothing says which."""
        if self._lost.parts:
            self.remarks.append(str(self._lost))
        if self._unknown:
            what = f"{self._unknown} messages of channels without a description are left out"
            self.remarks.append(what)
        wrong = summary.damaged
        if end is not None and end.end - end.start >= 4:
            (checksum,) = struct.unpack_from("<I", data, end.start)
            wrong |= checksum != 0 and zlib.crc32(data[: end.start - HEAD]) != checksum
        if not wrong or self._lost.parts:
            return
        if not self._proven:
            what = "damaged: the checksum of the file is wrong, and nothing says where"
            raise FlatplankError(what, self.path.name, COPY)
        self.remarks.append(f"damaged outside of its samples (checksum); {COPY}")
