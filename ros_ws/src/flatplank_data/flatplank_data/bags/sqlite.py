# SPDX-License-Identifier: Apache-2.0
"""Reads SQLite bags (`.db3`), rosbag2's older storage, with the log that lies beside them.

A recorder that was killed leaves a write-ahead log (`.db3-wal`) or a rollback journal; SQLite
applies them when it opens a database, and writes while it does. So the files are copied first, and
the user's folder stays as it is.
"""

from __future__ import annotations

import shutil
import sqlite3
import struct
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from flatplank_data.bags.blocks import Block, Channel, blocks_of
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget

LOGS = ("-wal", "-journal")
"""suffixes of what SQLite lays beside a database"""
_WAL_HEAD, _FRAME_HEAD = 32, 24
_TABLES = {"topics": {"id", "name", "type"}, "messages": {"topic_id", "timestamp", "data"}}


class SqliteFile:
    """One .db3 file: tables `topics` and `messages`."""

    def __init__(self, path: Path, budget: Budget | None = None) -> None:
        self.path = path
        self.remarks: list[str] = []
        self.budget = budget or Budget.of(path.name, path.stat().st_size)

    def blocks(self, wanted: set[str]) -> Iterator[Block]:
        """Messages of the wanted topics. Raises FlatplankError."""
        try:
            with self._database() as base:
                _check(base)
                definitions = _definitions(base)
                columns = _columns(base, "topics")
                coding = "serialization_format" if "serialization_format" in columns else "'cdr'"
                rows = base.execute(f"SELECT id, name, type, {coding} FROM topics").fetchall()
                for number, topic, kind, code in rows:
                    if topic in wanted:
                        text, language = definitions.get(kind, ("", ""))
                        channel = Channel(topic, str(kind), text, language, str(code or "cdr"))
                        yield from _messages(base, number, channel)
        except (sqlite3.Error, UnicodeDecodeError, OverflowError, TypeError, ValueError) as error:
            raise FlatplankError(
                f"not a whole rosbag2 database ({error})",
                self.path.name,
                f"copy it again, or recover it: sqlite3 {self.path.name} .recover",
            ) from error
        except OSError as error:
            what = f"cannot be copied to apply the log beside it ({error.strerror})"
            raise FlatplankError(
                what, self.path.name, "make room in the temporary folder"
            ) from error

    @contextmanager
    def _database(self) -> Iterator[sqlite3.Connection]:
        logs = [self.path.with_name(self.path.name + suffix) for suffix in LOGS]
        logs = [log for log in logs if log.exists() and log.stat().st_size]
        if not logs:
            with closing(
                sqlite3.connect(f"{self.path.absolute().as_uri()}?immutable=1", uri=True)
            ) as base:
                yield base
            return
        with tempfile.TemporaryDirectory(prefix="flatplank-") as folder:
            for file in (self.path, *logs):
                shutil.copyfile(file, Path(folder) / file.name)
            with closing(sqlite3.connect(Path(folder) / self.path.name)) as base:
                self._apply(base, logs)
                yield base

    def _apply(self, base: sqlite3.Connection, logs: list[Path]) -> None:
        """Apply the log; tell when a part of it is damaged or unfinished."""
        wal = next((log for log in logs if log.name.endswith(LOGS[0])), None)
        applied = max(base.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()[1], 0)
        of = _frames(wal) if wal else applied
        if applied < of:
            what = f"{applied} of {of} pages of the log {wal.name if wal else ''} are whole"
            self.remarks.append(f"{what} (recorder killed, or damaged): read as far as it goes")


def _frames(wal: Path) -> int:
    """Number of pages that a write-ahead log holds (https://sqlite.org/fileformat2.html#walformat).

    Pages of an older round have another salt than the head.
    """
    data = np.fromfile(wal, dtype=np.uint8)
    if data.size < _WAL_HEAD:
        return 1
    (page,) = struct.unpack_from(">I", data, 8)
    count = (data.size - _WAL_HEAD) // (_FRAME_HEAD + page)
    if not count or not page:
        return 1
    starts = _WAL_HEAD + (_FRAME_HEAD + page) * np.arange(count)
    salts = data[starts[:, None] + np.arange(8, 16)]
    return max(int((salts == data[16:24]).all(axis=1).sum()), 1)


def _check(base: sqlite3.Connection) -> None:
    """Raise sqlite3.DatabaseError for another database, or a damaged one."""
    for name, needed in _TABLES.items():
        kind = base.execute("SELECT type FROM sqlite_master WHERE name=?", (name,)).fetchone()
        if kind != ("table",) or not needed <= _columns(base, name):
            raise sqlite3.DatabaseError(f"no table '{name}' with {', '.join(sorted(needed))}")
    (found,) = base.execute("PRAGMA quick_check(1)").fetchone()
    if found != "ok":
        raise sqlite3.DatabaseError(found)


def _columns(base: sqlite3.Connection, table: str) -> set[str]:
    return {row[1] for row in base.execute(f"PRAGMA table_info({table})")}


def _definitions(base: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Type -> definition and its language."""
    try:
        query = "SELECT topic_type, encoded_message_definition FROM message_definitions"
        texts = {kind: str(text) for kind, text in base.execute(query)}
    except sqlite3.OperationalError:
        return {}
    languages = {}
    if "encoding" in _columns(base, "message_definitions"):
        languages = dict(base.execute("SELECT topic_type, encoding FROM message_definitions"))
    return {kind: (text, languages.get(kind, "ros2msg")) for kind, text in texts.items()}


def _messages(base: sqlite3.Connection, number: int, channel: Channel) -> Iterator[Block]:
    query = "SELECT timestamp, data FROM messages WHERE topic_id=? ORDER BY length(data)"
    cursor = base.execute(query, (number,))
    while rows := cursor.fetchmany(4096):
        if not all(isinstance(time, int) and isinstance(data, bytes) for time, data in rows):
            raise ValueError(f"a message of {channel.topic} is not bytes with a time")
        times = np.array([time for time, _ in rows], dtype=np.int64)
        yield from blocks_of(channel, times, [data for _, data in rows])
