# SPDX-License-Identifier: Apache-2.0
"""Reads the storage files of rosbag2, MCAP and SQLite, as blocks of messages.

MCAP (https://mcap.dev/spec) is read from front to back, so a truncated file can be read too.
Messages are found through the index that follows each chunk, so that no Python code runs per
message.
"""

from __future__ import annotations

import mmap
import sqlite3
import struct
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard

from flatplank_data.errors import FlatplankError

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, INDEX, DATA_END = 3, 4, 5, 6, 7, 15
_HEAD = 9
"""bytes before a record: opcode, length"""
_MESSAGE_HEAD = 22
"""bytes before the payload: channel, sequence, log and publish time"""


@dataclass(frozen=True)
class Channel:
    """A topic of the bag with its type."""

    topic: str
    type: str
    definition: str


@dataclass(frozen=True)
class Block:
    """Messages of one channel with payloads of one size."""

    channel: Channel
    log_time: np.ndarray
    """(messages,) [ns]"""
    payloads: np.ndarray
    """(messages, bytes) uint8"""


def blocks_of(channel: Channel, times: np.ndarray, payloads: Sequence[bytes]) -> Iterator[Block]:
    """Messages of one channel as blocks of one payload size each."""
    sizes = np.array([len(data) for data in payloads])
    for size in np.unique(sizes):
        same = np.flatnonzero(sizes == size)
        matrix = np.frombuffer(b"".join(payloads[i] for i in same), dtype=np.uint8)
        yield Block(channel, times[same], matrix.reshape(len(same), int(size)))


class McapFile:
    """One .mcap file. `cut_short` is set when the end is missing."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.cut_short = False
        self._schemas: dict[int, tuple[str, str]] = {}
        self._channels: dict[int, Channel] = {}

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics, chunk by chunk."""
        with open(self.path, "rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                what = "not an MCAP file, or empty"
                raise FlatplankError(what, self.path.name, "start the recorder again to repair it")
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                yield from self._read(data, wanted)

    def _read(self, data: mmap.mmap, wanted: set[str]) -> Iterator[Block]:
        at, end = len(MAGIC), len(data)
        chunk: np.ndarray | None = None
        index: dict[int, np.ndarray] = {}
        loose: list[tuple[int, int]] = []
        while True:
            if at + _HEAD > end:
                self.cut_short = True
                break
            opcode, size = struct.unpack_from("<BQ", data, at)
            at += _HEAD
            if opcode != INDEX and chunk is not None:
                yield from self._chunk(chunk, index, wanted)
                chunk, index = None, {}
            if at + size > end:
                self.cut_short = True
                if opcode == CHUNK:
                    yield from self._torn_chunk(data[at:end], wanted)
                break
            if opcode == DATA_END:
                break
            if opcode == CHUNK:
                chunk = self._unpack(data[at : at + size])
            elif opcode == INDEX and chunk is not None:
                channel, length = struct.unpack_from("<HI", data, at)
                entries = np.frombuffer(data[at + 6 : at + 6 + length], dtype="<u8")
                if entries.size:
                    index[channel] = entries.reshape(-1, 2)
            elif opcode == MESSAGE:
                loose.append((at - _HEAD, size))
            else:
                self._describe(opcode, data[at : at + size])
            at += size
        if chunk is not None:
            yield from self._chunk(chunk, index, wanted)
        if loose:
            buffer = np.frombuffer(data[:], dtype=np.uint8)
            yield from self._select(buffer, _by_channel(buffer, [a for a, _ in loose]), wanted)

    def _unpack(self, record: bytes) -> np.ndarray:
        """Records of a chunk, uncompressed."""
        (name_size,) = struct.unpack_from("<I", record, 28)
        compression = record[32 : 32 + name_size].decode()
        (raw_size,) = struct.unpack_from("<Q", record, 16)
        body = _decompress(compression, record[40 + name_size :], raw_size)
        return np.frombuffer(body, dtype=np.uint8)

    def _torn_chunk(self, record: bytes, wanted: set[str]) -> Iterator[Block]:
        """The complete messages of a truncated chunk; none when the chunk is compressed."""
        if len(record) < 40:
            return
        (name_size,) = struct.unpack_from("<I", record, 28)
        if name_size:
            return
        yield from self._chunk(np.frombuffer(record[40:], dtype=np.uint8), {}, wanted)

    def _chunk(
        self, buffer: np.ndarray, index: dict[int, np.ndarray], wanted: set[str]
    ) -> Iterator[Block]:
        if not index or any(channel not in self._channels for channel in index):
            offsets = self._scan(buffer)
            if not index:
                yield from self._select(buffer, _by_channel(buffer, offsets), wanted)
                return
        found = {c: entries[:, 1].astype(np.int64) for c, entries in index.items()}
        yield from self._select(buffer, found, wanted)

    def _scan(self, buffer: np.ndarray) -> list[int]:
        """Read the record headers of a chunk: register its channels, return the offsets of its
        messages."""
        data, at, offsets = buffer.tobytes(), 0, []
        while at + _HEAD <= len(data):
            opcode, size = struct.unpack_from("<BQ", data, at)
            if at + _HEAD + size > len(data):
                break
            if opcode == MESSAGE:
                offsets.append(at)
            else:
                self._describe(opcode, data[at + _HEAD : at + _HEAD + size])
            at += _HEAD + size
        return offsets

    def _describe(self, opcode: int, record: bytes) -> None:
        """Register the schema or channel of a record; ignore other records."""
        if opcode == SCHEMA:
            (number,) = struct.unpack_from("<H", record)
            name, at = _text(record, 2)
            _, at = _text(record, at)
            definition, _ = _text(record, at)
            self._schemas[number] = (name, definition)
        elif opcode == CHANNEL:
            number, schema = struct.unpack_from("<HH", record)
            topic, _ = _text(record, 4)
            name, definition = self._schemas.get(schema, ("", ""))
            self._channels[number] = Channel(topic, name, definition)

    def _select(
        self, buffer: np.ndarray, found: dict[int, np.ndarray], wanted: set[str]
    ) -> Iterator[Block]:
        for number, offsets in found.items():
            channel = self._channels.get(number)
            if channel is None or channel.topic not in wanted:
                continue
            heads = _windows(buffer, offsets, _HEAD + _MESSAGE_HEAD)
            sizes = np.ascontiguousarray(heads[:, 1:9]).view("<u8")[:, 0] - _MESSAGE_HEAD
            times = np.ascontiguousarray(heads[:, 15:23]).view("<u8")[:, 0]
            for size in np.unique(sizes):
                same = sizes == size
                start = offsets[same] + _HEAD + _MESSAGE_HEAD
                payloads = _windows(buffer, start, int(size))
                yield Block(channel, times[same].astype(np.int64), payloads)


def _windows(buffer: np.ndarray, offsets: np.ndarray, size: int) -> np.ndarray:
    """Rows of `size` bytes from each offset, shape (offsets, size)."""
    return np.lib.stride_tricks.sliding_window_view(buffer, size)[offsets]


def _by_channel(buffer: np.ndarray, offsets: list[int]) -> dict[int, np.ndarray]:
    where = np.asarray(offsets, dtype=np.int64)
    if not where.size:
        return {}
    numbers = buffer[where + _HEAD].astype(np.int64)
    numbers = numbers + 256 * buffer[where + _HEAD + 1].astype(np.int64)
    return {int(n): where[numbers == n] for n in np.unique(numbers)}


def _text(record: bytes, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", record, at)
    return record[at + 4 : at + 4 + size].decode("utf-8", "replace"), at + 4 + size


def _decompress(compression: str, body: bytes, size: int) -> bytes:
    if compression == "lz4":
        return lz4.frame.decompress(body)
    if compression == "zstd":
        return zstandard.ZstdDecompressor().decompress(body, max_output_size=size)
    if compression:
        raise FlatplankError(f"chunk compression '{compression}'", "bag", "use none, lz4 or zstd")
    return body


class SqliteFile:
    """One .db3 file, rosbag2's older storage: tables `topics` and `messages`."""

    cut_short = False

    def __init__(self, path: Path) -> None:
        self.path = path

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics."""
        uri = f"file:{self.path}?mode=ro&immutable=1"
        try:
            with closing(sqlite3.connect(uri, uri=True)) as base:
                definitions = _definitions(base)
                topics = base.execute("SELECT id, name, type FROM topics").fetchall()
                for number, topic, kind in topics:
                    if topic in wanted:
                        channel = Channel(topic, kind, definitions.get(kind, ""))
                        yield from _messages(base, number, channel)
        except sqlite3.DatabaseError as error:
            raise FlatplankError(
                f"not a whole rosbag2 database ({error})", self.path.name, "convert it to MCAP"
            ) from error


def _definitions(base: sqlite3.Connection) -> dict[str, str]:
    try:
        query = "SELECT topic_type, encoded_message_definition FROM message_definitions"
        return dict(base.execute(query).fetchall())
    except sqlite3.OperationalError:
        return {}


def _messages(base: sqlite3.Connection, number: int, channel: Channel) -> Iterator[Block]:
    query = "SELECT timestamp, data FROM messages WHERE topic_id=? ORDER BY length(data)"
    cursor = base.execute(query, (number,))
    while rows := cursor.fetchmany(4096):
        times = np.array([time for time, _ in rows], dtype=np.int64)
        yield from blocks_of(channel, times, [data for _, data in rows])
