# SPDX-License-Identifier: Apache-2.0
"""Records of MCAP files and their checksums (https://mcap.dev/spec)."""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from flatplank_data.bags.blocks import Channel
from flatplank_data.guard import Budget, DamagedError

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, INDEX, CHUNK_INDEX, DATA_END = 2, 3, 4, 5, 6, 7, 8, 15
PRIVATE = 0x80
"""first opcode that is free for anybody"""
HEAD = 9
"""bytes before a record: opcode, length"""
MESSAGE_HEAD = 22
"""bytes before the payload: channel, sequence, log and publish time"""
Buffer: TypeAlias = "bytes | mmap.mmap"
_FOOTER = struct.Struct("<BQQQI")
_CHUNK = struct.Struct("<QQQII")


class Record(NamedTuple):
    """Opcode and place of the content of a record [bytes]."""

    opcode: int
    start: int
    end: int


def records(data: Buffer, at: int, end: int) -> Iterator[Record]:
    """Records one after the other. Raises DamagedError where no record can begin."""
    while at + HEAD <= end:
        opcode, size = struct.unpack_from("<BQ", data, at)
        if not opcode or DATA_END < opcode < PRIVATE:
            raise DamagedError("no record")
        if size > end - at - HEAD:
            raise DamagedError("a record is longer than the rest")
        at += HEAD
        yield Record(opcode, at, at + size)
        at += size
    if at != end:
        raise DamagedError("a record is cut short")


def _text(record: bytes, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", record, at)
    if size > len(record) - at - 4:
        raise DamagedError("a text is cut short")
    return record[at + 4 : at + 4 + size].decode("utf-8", "replace"), at + 4 + size


@dataclass
class Channels:
    """Schemas and channels by number."""

    by_number: dict[int, Channel] = field(default_factory=dict)
    _schemas: dict[int, tuple[str, str, str]] = field(default_factory=dict)

    def add(self, opcode: int, record: bytes) -> bool:
        """Register the schema or channel of a record; true when it is new. The first one counts:
        those of a summary with a right checksum come first."""
        before = len(self._schemas) + len(self.by_number)
        try:
            if opcode == SCHEMA:
                (number,) = struct.unpack_from("<H", record)
                name, at = _text(record, 2)
                language, at = _text(record, at)
                self._schemas.setdefault(number, (name, _text(record, at)[0], language))
            elif opcode == CHANNEL:
                number, schema = struct.unpack_from("<HH", record)
                topic, at = _text(record, 4)
                name, definition, language = self._schemas.get(schema, ("", "", ""))
                coding, _ = _text(record, at)
                channel = Channel(topic, name, definition, language, coding)
                self.by_number.setdefault(number, channel)
        except struct.error:
            raise DamagedError("a channel is cut short") from None
        return len(self._schemas) + len(self.by_number) > before


@dataclass
class Summary:
    """Content of the summary at the end of a file; `right` when its checksum says so."""

    right: bool = False
    damaged: bool = False
    """the checksum contradicts"""
    channels: Channels = field(default_factory=Channels)
    chunks: list[int] = field(default_factory=list)
    """where chunks begin [bytes], in order"""


def read_summary(data: Buffer) -> Summary:
    """The summary; nothing is taken from a summary without a right checksum."""
    found = Summary()
    at = len(data) - len(MAGIC) - _FOOTER.size
    if at < len(MAGIC) or data[-len(MAGIC) :] != MAGIC:
        return found
    opcode, size, start, _, crc = _FOOTER.unpack_from(data, at)
    if opcode != FOOTER or size != _FOOTER.size - HEAD or not len(MAGIC) <= start <= at:
        found.damaged = opcode != FOOTER or start != 0
        return found
    if crc == 0:
        return found
    found.damaged = zlib.crc32(data[start : at + _FOOTER.size - 4]) != crc
    if found.damaged:
        return found
    try:
        for opcode, begin, end in records(data, start, at):
            found.channels.add(opcode, bytes(data[begin:end]))
            if opcode == CHUNK_INDEX:
                found.chunks.append(struct.unpack_from("<Q", data, begin + 16)[0])
    except (DamagedError, struct.error):
        return Summary(damaged=True)
    found.chunks.sort()
    found.right = True
    return found


def unpack_chunk(record: bytes, budget: Budget) -> tuple[np.ndarray, bool]:
    """Records of a chunk, and whether it has a checksum. Raises DamagedError when it is wrong."""
    if len(record) < _CHUNK.size + 8:
        raise DamagedError("a chunk is cut short")
    _, _, size, crc, name_size = _CHUNK.unpack_from(record)
    name = bytes(record[_CHUNK.size : _CHUNK.size + name_size])
    at = _CHUNK.size + name_size
    if name not in (b"", b"lz4", b"zstd") or at + 8 > len(record):
        text = name[:8].decode() if name.isalnum() and name.isascii() else "of damaged name"
        raise DamagedError(f"the compression {text} is not none, lz4 or zstd")
    (body_size,) = struct.unpack_from("<Q", record, at)
    body = record[at + 8 :]
    if body_size != len(body) or (not name and size != body_size):
        raise DamagedError("a chunk has another size than it says")
    if name:
        body = (budget.zstd if name == b"zstd" else budget.lz4)(body, size)
    if crc and zlib.crc32(body) != crc:
        raise DamagedError("checksum")
    return np.frombuffer(body, dtype=np.uint8), crc != 0


def torn_chunk(record: bytes) -> np.ndarray:
    """What is left of a chunk that lost its end; nothing when the chunk is compressed."""
    if len(record) < _CHUNK.size + 8 or record[_CHUNK.size - 4 : _CHUNK.size] != b"\0\0\0\0":
        return np.empty(0, dtype=np.uint8)
    return np.frombuffer(record[_CHUNK.size + 8 :], dtype=np.uint8)
