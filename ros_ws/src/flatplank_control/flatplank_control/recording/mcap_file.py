# SPDX-License-Identifier: Apache-2.0
"""An MCAP file that grows by whole chunks, so that it stays readable after any interruption.

It uses the records of the `mcap` package, but not its writer: here a chunk and its index are
written at once, a failed write is undone, and a truncated file can be finished (`recovery`).
Format: https://mcap.dev/spec.
"""

from __future__ import annotations

import fcntl
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path
from struct import Struct, pack

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
LIBRARY = "flatplank"
MESSAGE = Struct("<BQHIQQ")
"""opcode, length, channel, sequence, log time, publish time"""
CHUNK = Struct("<BQQQQIIQ")
"""opcode, length, first and last stamp, size, CRC, length of the compression's name, size"""


def encode(*records: McapRecord) -> bytes:
    """Bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


@dataclass
class Index:
    """Content of the summary at the end of a file."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    """messages per channel"""

    def add_chunk(
        self, at: int, end: int, start_ns: int, end_ns: int, size: int,
        offsets: dict[int, int], counts: Mapping[int, int],
    ) -> None:  # fmt: skip
        """Add a chunk from `at` to the `end` of its message indexes, with records of `size`
        [bytes].

        By channel: `offsets` of the message indexes and `counts` of messages.
        """
        length = CHUNK.size + size
        self.chunks.append(
            ChunkIndex(
                message_start_time=start_ns,
                message_end_time=end_ns,
                chunk_start_offset=at,
                chunk_length=length,
                message_index_offsets=offsets,
                message_index_length=end - at - length,
                compression="",
                compressed_size=size,
                uncompressed_size=size,
            )
        )
        for channel, count in counts.items():
            self.counts[channel] = self.counts.get(channel, 0) + count

    @property
    def messages(self) -> int:
        return sum(self.counts.values())

    @property
    def start_ns(self) -> int:
        return min((chunk.message_start_time for chunk in self.chunks), default=0)

    @property
    def end_ns(self) -> int:
        return max((chunk.message_end_time for chunk in self.chunks), default=0)


class McapFile:
    """Appends to one MCAP file; keeps the index for the summary."""

    def __init__(self, stream: FileIO, index: Index | None = None, position: int = 0) -> None:
        """`stream` is unbuffered; `index` and `position` [bytes] continue a truncated file."""
        self._stream = stream
        self.index = index or Index()
        self.position = position
        self._clear()
        if position == 0:
            self._append(MAGIC + encode(Header(profile="ros2", library=LIBRARY)))

    @classmethod
    def create(cls, path: Path) -> McapFile:
        """Create a file, locked while it is open, so that no recovery touches it."""
        stream = FileIO(path, "xb")
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return cls(stream)

    @property
    def pending(self) -> int:
        """Number of bytes that a kill would lose."""
        return self._offset

    def add_schema(self, name: str, definition: str) -> int:
        """Add a schema; returns its number."""
        number = len(self.index.schemas) + 1
        schema = Schema(id=number, data=definition.encode(), encoding="ros2msg", name=name)
        self._append(encode(schema))
        self.index.schemas[number] = schema
        return number

    def add_channel(self, topic: str, schema: int, metadata: dict[str, str]) -> int:
        """Add a channel; returns its number."""
        number = len(self.index.channels) + 1
        channel = Channel(
            id=number, topic=topic, message_encoding="cdr", metadata=metadata, schema_id=schema
        )
        self._append(encode(channel))
        self.index.channels[number] = channel
        return number

    def add(self, channel: int, log_ns: int, data: bytes, stamp_ns: int) -> None:
        """Add a message with its log and publish time; the next `flush` writes it to disk."""
        size = len(data)
        self._parts.append(MESSAGE.pack(5, 22 + size, channel, 0, log_ns, stamp_ns))
        self._parts.append(data)
        entries = self._entries.get(channel)
        if entries is None:
            entries = self._entries[channel] = []
        entries.append(log_ns)
        entries.append(self._offset)
        self._offset += 31 + size

    def flush(self) -> None:
        """Write the pending messages as one chunk."""
        if not self._offset:
            return
        data = b"".join(self._parts)
        logs = [log for entries in self._entries.values() for log in entries[::2]]
        index = {
            channel: pack(f"<{len(entries)}Q", *entries)
            for channel, entries in self._entries.items()
        }
        self._clear()
        self.add_chunk(data, min(logs), max(logs), index)

    def add_chunk(self, data: bytes, start_ns: int, end_ns: int, index: dict[int, bytes]) -> None:
        """Append serialised message records as one chunk.

        `index` per channel: pairs of uint64, time [ns] and offset in `data` [bytes].
        """
        self.flush()
        size = len(data)
        head = CHUNK.pack(6, 40 + size, start_ns, end_ns, size, zlib.crc32(data), 0, size)
        parts = [head, data]
        offset = self.position + len(head) + size
        offsets = {}
        for channel, entries in index.items():
            offsets[channel] = offset
            parts.append(pack("<BQHI", 7, 6 + len(entries), channel, len(entries)))
            parts.append(entries)
            offset += 15 + len(entries)
        at = self.position
        self._append(b"".join(parts))
        counts = {channel: len(entries) // 16 for channel, entries in index.items()}
        self.index.add_chunk(at, offset, start_ns, end_ns, size, offsets, counts)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Add a metadata record, such as that of rosbag2."""
        self.flush()
        data = encode(Metadata(name=name, metadata=values))
        entry = MetadataIndex(offset=self.position, length=len(data), name=name)
        self._append(data)
        self.index.metadata.append(entry)

    def finish(self) -> None:
        """Write the summary and close."""
        self.flush()
        data_end = encode(DataEnd(0))
        self._append(data_end + _summary(self.index, self.position + len(data_end)) + MAGIC)
        self._stream.close()

    def abandon(self) -> None:
        """Close without finishing; pending messages are lost."""
        self._clear()
        self._stream.close()

    def drop_pending(self) -> None:
        """Discard the pending messages."""
        self._clear()

    def _clear(self) -> None:
        self._parts: list[bytes] = []
        self._entries: dict[int, list[int]] = {}
        self._offset = 0

    def _append(self, data: bytes) -> None:
        """Write all of the data or nothing."""
        try:
            view = memoryview(data)
            while view:
                view = view[self._stream.write(view) or 0 :]
        except OSError:
            self._stream.truncate(self.position)
            self._stream.seek(self.position)
            raise
        self.position += len(data)


def _summary(index: Index, start: int) -> bytes:
    """Summary section, summary offsets and footer; `start` is where they begin [bytes]."""
    statistics = Statistics(
        attachment_count=0,
        channel_count=len(index.channels),
        channel_message_counts=index.counts,
        chunk_count=len(index.chunks),
        message_count=index.messages,
        metadata_count=len(index.metadata),
        message_start_time=index.start_ns,
        message_end_time=index.end_ns,
        schema_count=len(index.schemas),
    )
    groups = {
        Opcode.SCHEMA: encode(*index.schemas.values()),
        Opcode.CHANNEL: encode(*index.channels.values()),
        Opcode.STATISTICS: encode(statistics),
        Opcode.CHUNK_INDEX: encode(*index.chunks),
        Opcode.METADATA_INDEX: encode(*index.metadata),
    }
    summary, offsets = b"", []
    for opcode, data in groups.items():
        if data:
            offsets.append(SummaryOffset(opcode, start + len(summary), len(data)))
        summary += data
    offset_start = start + len(summary)
    summary += encode(*offsets)
    crc = zlib.crc32(pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start), zlib.crc32(summary))
    return summary + encode(Footer(start, offset_start, crc))
