# SPDX-License-Identifier: Apache-2.0
"""rosbag2's older storage: an SQLite file with tables `topics` and `messages`."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np

from flatplank_data.bags.mcap import Block, Channel
from flatplank_data.errors import FlatplankError


class SqliteFile:
    """One .db3 file."""

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
                        channel = Channel(topic, kind, definitions.get(kind, ""), "cdr")
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
        sizes = np.array([len(data) for _, data in rows])
        for size in np.unique(sizes):
            same = [rows[i] for i in np.flatnonzero(sizes == size)]
            matrix = np.frombuffer(b"".join(d for _, d in same), dtype=np.uint8)
            times = np.array([t for t, _ in same], dtype=np.int64)
            yield Block(channel, times, matrix.reshape(len(same), int(size)))
