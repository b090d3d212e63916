# SPDX-License-Identifier: Apache-2.0
"""Finds the complete records of an unfinished MCAP file of the recorder, and where they end."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Header, Schema

from flatplank_control.recording.mcap_file import CHUNK, LIBRARY, MAGIC, MESSAGE, Index
from flatplank_data.errors import RecordingError

_RECORD = Struct("<BQ")
_INDEX = Struct("<BQHI")


class ScannedMessage(NamedTuple):
    """A message in a chunk."""

    channel: int
    log_ns: int
    data: bytes
    stamp_ns: int


@dataclass
class Scan:
    """Complete parts of a file."""

    index: Index = field(default_factory=Index)
    end: int = 0
    """position for the next record [bytes]; the rest is truncated or the old summary"""
    rest: list[ScannedMessage] = field(default_factory=list)
    """complete messages of the chunk that was being written"""
    finished: bool = False
    """true when the file has its summary and closing magic"""


class _DamageError(Exception):
    """The bytes are not a valid record."""


def messages_of(data: bytes) -> Iterator[ScannedMessage]:
    """Complete messages in the records of a chunk."""
    at, size = 0, len(data)
    while at + MESSAGE.size <= size:
        opcode, length, channel, _, log_ns, stamp_ns = MESSAGE.unpack_from(data, at)
        end = at + 9 + length
        if opcode != Opcode.MESSAGE or length < 22 or end > size:
            return
        yield ScannedMessage(channel, log_ns, data[at + MESSAGE.size : end], stamp_ns)
        at = end


def stored_messages(path: Path, index: Index) -> Iterator[ScannedMessage]:
    """Yield all messages of a scanned file, chunk by chunk."""
    with path.open("rb") as file:
        for chunk in index.chunks:
            file.seek(chunk.chunk_start_offset + CHUNK.size)
            yield from messages_of(file.read(chunk.uncompressed_size))


def scan(path: Path) -> Scan:
    """Scan a file from its beginning; RecordingError for a file of another writer or a damaged
    one."""
    with path.open("rb") as file:
        data = file.read()
    result = Scan(finished=data.endswith(MAGIC) and len(data) > 2 * len(MAGIC))
    if not MAGIC.startswith(data[: len(MAGIC)]):
        raise RecordingError(f"{path}: not an MCAP file; remove it or name another folder")
    if len(data) < len(MAGIC):
        return result
    at = len(MAGIC)
    try:
        while at + _RECORD.size <= len(data):
            opcode, length = _RECORD.unpack_from(data, at)
            reader = _READERS.get(opcode)
            if reader is None:
                break
            end = at + _RECORD.size + length
            whole = end <= len(data)
            if not whole and opcode != Opcode.CHUNK:
                break
            reader(result, data, at, min(end, len(data)))
            if not whole:
                break
            at = end
    except _DamageError:
        if result.finished or _goes_on(data, at):
            raise RecordingError(f"{path}: damaged at byte {at}; restore it from a copy") from None
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from None
    return result


def _goes_on(data: bytes, at: int) -> bool:
    """True when a further complete chunk follows the record at `at`."""
    while at + _RECORD.size <= len(data):
        at += _RECORD.size + _RECORD.unpack_from(data, at)[1]
        if data[at : at + 1] == bytes([Opcode.CHUNK]):
            scanned = Scan()
            with suppress(_DamageError):
                _chunk(scanned, data, at, at + 9 + _RECORD.unpack_from(data, at)[1])
            return bool(scanned.index.chunks)
    return False


def _header(result: Scan, data: bytes, at: int, end: int) -> None:
    header = Header.read(ReadDataStream(BytesIO(data[at + 9 : end])))
    if header.library != LIBRARY:
        raise RecordingError(f"written by {header.library!r}, not by this recorder; left alone")
    result.end = end


def _listed(name: str, kind: type[Schema] | type[Channel]) -> _Reader:
    """Reader that puts a record into a table of the index, by its id."""

    def read(result: Scan, data: bytes, at: int, end: int) -> None:
        record = kind.read(ReadDataStream(BytesIO(data[at + 9 : end])))
        getattr(result.index, name)[record.id] = record
        result.end = end

    return read


def _chunk(result: Scan, data: bytes, at: int, end: int) -> None:
    """Read a chunk; it is complete when all its message indexes follow, else its messages go to
    `rest`."""
    content = data[at + CHUNK.size : end]
    messages = list(messages_of(content))
    result.rest = messages
    if len(data) < at + CHUNK.size:
        return
    _, length, start_ns, end_ns, size, crc, _, _ = CHUNK.unpack_from(data, at)
    if len(content) != length - 40:
        return
    if size != len(content) or zlib.crc32(content) != crc:
        result.rest = []
        raise _DamageError
    offsets, where = _indexes(data, end)
    if offsets.keys() != {message.channel for message in messages}:
        return
    result.rest = []
    counts = Counter(message.channel for message in messages)
    result.index.add_chunk(at, where, start_ns, end_ns, size, offsets, counts)
    result.end = where


def _indexes(data: bytes, at: int) -> tuple[dict[int, int], int]:
    """Complete message indexes at `at`: position by channel, and their end [bytes]."""
    offsets: dict[int, int] = {}
    while at + _INDEX.size <= len(data):
        opcode, length, channel, _ = _INDEX.unpack_from(data, at)
        if opcode != Opcode.MESSAGE_INDEX or at + 9 + length > len(data):
            break
        offsets[channel] = at
        at += 9 + length
    return offsets, at


_Reader = Callable[[Scan, bytes, int, int], None]
_READERS: dict[int, _Reader] = {
    Opcode.HEADER: _header,
    Opcode.SCHEMA: _listed("schemas", Schema),
    Opcode.CHANNEL: _listed("channels", Channel),
    Opcode.CHUNK: _chunk,
    Opcode.MESSAGE_INDEX: lambda *_: None,  # read with its chunk
}
