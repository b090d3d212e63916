# SPDX-License-Identifier: Apache-2.0
"""Reads bags of ROS 1 (`.bag`) with `rosbags`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import decompressors

from flatplank_data.bags.blocks import Block, Channel, blocks_of
from flatplank_data.bags.definitions import ROS1
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget


class Ros1File:
    """One .bag file."""

    def __init__(self, path: Path, budget: Budget | None = None) -> None:
        self.path = path
        self.remarks: list[str] = []
        self.budget = budget or Budget.of(path.name, path.stat().st_size)

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics. Raises FlatplankError."""
        found: dict[Channel, list[tuple[int, bytes]]] = {}
        try:
            with Reader(self.path) as reader:
                self._bound(reader)
                _check_index(reader)
                chosen = [c for c in reader.connections if c.topic in wanted]
                for connection, time, data in reader.messages(chosen) if chosen else ():
                    self.budget.take(len(data))
                    text = str(connection.msgdef.data)
                    channel = Channel(connection.topic, connection.msgtype, text, "", ROS1)
                    found.setdefault(channel, []).append((time, bytes(data)))
        except FlatplankError:
            raise
        except Exception as error:  # rosbags raises many types of errors on a damaged file
            told = f"{type(error).__name__}: {error}".split("\n", 1)[0][:200]
            raise FlatplankError(
                f"not a whole bag of ROS 1 ({told})", self.path.name, "repair it: rosbag reindex"
            ) from error
        for channel, messages in found.items():
            times = np.array([time for time, _ in messages], dtype=np.int64)
            yield from blocks_of(channel, times, [data for _, data in messages])

    def _bound(self, reader: Reader) -> None:
        """Let chunks unpack to no more than the budget of the file."""
        bounded = {
            decompressors["bz2"]: self.budget.bz2,
            decompressors["lz4"]: self.budget.lz4,
        }
        for position, chunk in reader.chunks.items():
            unpack = bounded.get(chunk.decompressor, chunk.decompressor)
            reader.chunks[position] = chunk._replace(decompressor=unpack)


def _check_index(reader: Reader) -> None:
    """Raise ValueError when the index has not as many messages as the chunks are said to have."""
    counted: Counter[int] = Counter()
    for chunk in reader.chunk_infos:
        counted.update(chunk.connection_counts)
    for connection, count in counted.items():
        if len(reader.indexes.get(connection, ())) != count:
            raise ValueError(f"the index has not all {count} messages of connection {connection}")
