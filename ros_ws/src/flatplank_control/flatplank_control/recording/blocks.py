# SPDX-License-Identifier: Apache-2.0
"""Arrays of messages of many topics, as the twin makes them; merges them in time order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from flatplank_control.recording.cdr_layout import CdrLayout, set_stamps
from flatplank_data.errors import RecordingError

_HEAD = np.dtype(
    {
        "names": ["opcode", "length", "channel", "sequence", "log_time", "publish_time"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
        "offsets": [0, 1, 9, 11, 15, 23],
        "itemsize": 31,
    }
)


class TopicBlock(NamedTuple):
    """N messages of one topic, all of one size."""

    topic: str
    stamps_ns: np.ndarray
    """int64 [N], not decreasing"""
    payload: np.ndarray
    """array of N CDR messages: structured (`CdrLayout`) or uint8 [N, size]"""


def merge_blocks(
    blocks: Sequence[TopicBlock], channels: Mapping[str, int]
) -> tuple[bytes, int, int, dict[int, bytes]] | None:
    """Arguments of `McapFile.add_chunk`; messages of one stamp keep the order of `blocks`. None
    when there is no message."""
    blocks = [block for block in blocks if len(block.stamps_ns)]
    if not blocks:
        return None
    records = [_records(block, channels[block.topic]) for block in blocks]
    stamps = np.concatenate([np.asarray(block.stamps_ns, np.int64) for block in blocks])
    sizes = np.concatenate([np.full(len(r), r.shape[1], np.int64) for r in records])
    order = np.argsort(stamps, kind="stable")
    offsets: np.ndarray = np.empty(len(stamps), np.int64)
    ends = np.cumsum(sizes[order])
    offsets[order] = ends - sizes[order]
    data = np.empty(ends[-1], np.uint8)
    index: dict[int, list[np.ndarray]] = {}
    first = 0
    for block, record in zip(blocks, records, strict=True):
        where = offsets[first : first + len(record)]
        first += len(record)
        _scatter(data, where, record)
        entries = np.column_stack([np.asarray(block.stamps_ns, np.int64), where])
        index.setdefault(channels[block.topic], []).append(entries)
    packed = {
        channel: np.concatenate(parts).astype("<u8").tobytes() for channel, parts in index.items()
    }
    return data.tobytes(), int(stamps.min()), int(stamps.max()), packed


def unroll(blocks: Sequence[TopicBlock]) -> Iterator[tuple[str, bytes, int]]:
    """The messages one by one, as `merge_blocks` orders them: topic, CDR, stamp [ns]."""
    messages: list[tuple[str, bytes, int]] = []
    for block in blocks:
        data = np.ascontiguousarray(block.payload).tobytes()
        size = len(data) // max(len(block.stamps_ns), 1)
        for number, stamp_ns in enumerate(np.asarray(block.stamps_ns).tolist()):
            messages.append((block.topic, data[number * size : (number + 1) * size], stamp_ns))
    messages.sort(key=lambda message: message[2])
    yield from messages


def _records(block: TopicBlock, channel: int) -> np.ndarray:
    """Message records, uint8 [N, 31 + size]."""
    payload = np.ascontiguousarray(block.payload)
    count = len(block.stamps_ns)
    payload = payload.view(np.uint8).reshape(count, -1)
    records = np.empty((count, _HEAD.itemsize + payload.shape[1]), np.uint8)
    head: np.ndarray = np.zeros(count, _HEAD)
    head["opcode"] = 5
    head["length"] = 22 + payload.shape[1]
    head["channel"] = channel
    head["log_time"] = head["publish_time"] = block.stamps_ns
    records[:, : _HEAD.itemsize] = head.view(np.uint8).reshape(count, -1)
    records[:, _HEAD.itemsize :] = payload
    return records


def _scatter(data: np.ndarray, where: np.ndarray, record: np.ndarray) -> None:
    """Copy each row of `record` to its offset; evenly spaced rows, the usual case, in one copy."""
    count, size = record.shape
    step = int(where[1] - where[0]) if count > 1 else size
    if step >= size and (count < 2 or bool(np.all(np.diff(where) == step))):
        start = int(where[0])
        target = np.lib.stride_tricks.as_strided(data[start:], (count, size), (step, 1))
        target[...] = record
        return
    data[where[:, None] + np.arange(size)] = record


class BlockSink(Protocol):
    """Target of blocks: a BagWriter or a RecordingSession."""

    def write_blocks(self, blocks: Sequence[TopicBlock]) -> None: ...


class TwinWriter:
    """Collects chunks of a run per topic; `flush` writes those added since the last one.

    Messages with one stamp follow the order of `layouts`. One flush per second of bench time is
    efficient; the memory needed is that between two flushes.
    """

    def __init__(self, sink: BlockSink, layouts: Mapping[str, CdrLayout]) -> None:
        self._sink = sink
        self._layouts = dict(layouts)
        self._blocks: dict[str, list[TopicBlock]] = {topic: [] for topic in layouts}

    def add(
        self,
        topic: str,
        stamps_ns: np.ndarray,
        columns: Mapping[str, Any],
        layout: CdrLayout | None = None,
    ) -> None:
        """Add N messages: `stamps_ns` int64 [N] [ns] fill the header, `columns` the rest.

        Columns are named as in `CdrLayout.dtype`; shape [N], [N, n] or one value for all. Messages
        with other texts than the topic's need their own `layout`.
        """
        if topic not in self._layouts:
            raise RecordingError(f"{topic}: not a topic of this writer; give its layout")
        layout = layout or self._layouts[topic]
        stamps_ns = np.asarray(stamps_ns, np.int64)
        messages = layout.new(len(stamps_ns))
        names = layout.dtype.names or ()
        if "header.stamp.sec" in names:
            set_stamps(messages, stamps_ns)
        for name, values in columns.items():
            if name not in names:
                raise RecordingError(f"{topic}: no column {name!r} in {layout.msgtype}")
            messages[name] = values
        self._blocks[topic].append(TopicBlock(topic, stamps_ns, messages))

    def flush(self) -> None:
        """Write all that was added."""
        blocks = [block for added in self._blocks.values() for block in added]
        for added in self._blocks.values():
            added.clear()
        self._sink.write_blocks(blocks)
