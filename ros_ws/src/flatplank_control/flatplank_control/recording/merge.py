# SPDX-License-Identifier: Apache-2.0
"""Many messages of many topics into one chunk of an MCAP file, in time order, without a loop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

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


class MergedChunk(NamedTuple):
    """Arguments of `McapFile.add_chunk`."""

    data: bytes
    start_ns: int
    end_ns: int
    entries: dict[int, bytes]


def merge_blocks(blocks: Sequence[TopicBlock], channels: Mapping[str, int]) -> MergedChunk | None:
    """Messages of one stamp keep the order of `blocks`; None when there is no message."""
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
    return MergedChunk(data.tobytes(), int(stamps.min()), int(stamps.max()), packed)


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
    """Each row of `record` to its offset; evenly spaced ones, the usual case, as one copy."""
    count, size = record.shape
    step = int(where[1] - where[0]) if count > 1 else size
    if step >= size and (count < 2 or bool(np.all(np.diff(where) == step))):
        start = int(where[0])
        target = np.lib.stride_tricks.as_strided(data[start:], (count, size), (step, 1))
        target[...] = record
        return
    data[where[:, None] + np.arange(size)] = record
