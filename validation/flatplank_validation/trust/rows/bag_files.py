# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: MCAP, SQLite, ROS 1."""

from __future__ import annotations

import sqlite3
import struct
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mcap.writer import CompressionType
from rosbags.rosbag1 import Writer as Writer1
from rosbags.serde import SerdeError

from flatplank_data.bags.topics import topic_map
from flatplank_data.readers.bag import import_bag
from flatplank_data.readers.base import Loaded
from flatplank_validation.trust.files.bags import (
    JOINT,
    ROS1,
    STORE,
    TOPICS,
    as_a_stream,
    create,
    insert,
    messages,
    messages_of_ros1,
    plain,
    write_mcap,
    write_ros1,
)
from flatplank_validation.trust.files.judge import judged
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 20_000
"""damaged files of a night"""
ROWS = 60


def _read(path: Path) -> Loaded:
    return import_bag(path, topic_map({"topics": TOPICS}))


@row(
    "mcap", "damaged MCAP bags (plain, zstd, lz4, packed as a file)",
    "not refused in one line, a value that was not written, or rows lost without a word",
)  # fmt: skip
def damaged_mcap(o: Options) -> Tally:
    """Chunks have checksums, so that no value can be wrong."""

    def compare(loaded: Loaded, _: Path) -> None:
        rows = np.round(loaded.columns["plank_position"] / 1e-3)
        for name, factor in {"plank_position": 1e-3, "wheel_angle": 2e-3, "fx": 1.0}.items():
            np.testing.assert_array_equal(loaded.columns[name], factor * rows, name)
        np.testing.assert_array_equal(loaded.columns["fz"], 3700.0)
        assert loaded.remarks or np.array_equal(rows, np.arange(ROWS)), f"{rows.size} rows"

    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-mcap-") as folder:
        for packing in ("NONE", "ZSTD", "LZ4", "file"):
            kind = CompressionType["NONE" if packing == "file" else packing]
            path = Path(folder) / f"{packing}.mcap"
            write_mcap(path, plain(rows=ROWS), compression=kind, chunk_size=3000)
            path = as_a_stream(path) if packing == "file" else path
            out.join(judged(o, NIGHT // 4, path, _read, compare))
    return out


def _same(loaded: Loaded, payloads: list[bytes], read: Callable[[bytes], Any], count: int) -> None:
    """Positions of the plank are among those of another reader, and none is missing unsaid."""
    theirs, unread = [], 0
    for data in payloads:
        try:
            theirs.append(float(read(data).position[0]))
        except (SerdeError, ValueError, LookupError):  # of a text without its end, say
            unread += 1
    ours, there = Counter(loaded.columns["plank_position"]), Counter(theirs)
    more = [v for v in (ours - there).elements() if v == v]
    assert len(more) <= unread, f"{more[:3]} are not in the file"
    assert loaded.remarks or ours.total() == count, f"{ours.total()} of {count} rows"


@row(
    "sqlite", "damaged SQLite bags",
    "not refused in one line, other values than sqlite3 has, or rows lost without a word",
)  # fmt: skip
def damaged_sqlite(o: Options) -> Tally:
    """SQLite has no checksums: what another reader finds is right."""

    def compare(loaded: Loaded, folder: Path) -> None:
        path = folder / "r.db3" if folder.is_dir() else folder
        with closing(sqlite3.connect(f"{path.as_uri()}?immutable=1", uri=True)) as base:
            rows = base.execute("SELECT data FROM messages WHERE topic_id=1").fetchall()
        _same(loaded, [data for (data,) in rows], lambda d: STORE.deserialize_cdr(d, JOINT), ROWS)

    with tempfile.TemporaryDirectory(prefix="fp-sqlite-") as folder:
        path = Path(folder) / "r.db3"
        with closing(create(path, "DELETE")) as base:
            base.execute("PRAGMA page_size=512")
            insert(base, 0, ROWS)
            base.execute("COMMIT")
        counts = [{"topic_metadata": {"name": t}, "message_count": ROWS} for t in TOPICS]
        information = {"rosbag2_bagfile_information": {"topics_with_message_count": counts}}
        (Path(folder) / "metadata.yaml").write_text(yaml.safe_dump(information))
        return judged(o, NIGHT, path, lambda p: _read(p.parent), compare)


@row(
    "ros1", "damaged bags of ROS 1 (plain, bz2, lz4)",
    "not refused in one line, other values than a reader without the index, or rows lost "
    "without a word",
)  # fmt: skip
def damaged_ros1(o: Options) -> Tally:
    """Their index says how many messages there are; only lz4 and bz2 have checksums."""

    def compare(loaded: Loaded, path: Path) -> None:
        try:
            found = messages_of_ros1(path.read_bytes())["/enc"]
        except (struct.error, ValueError, LookupError, OSError, RuntimeError, EOFError):
            return  # damaged between the messages, which the index jumps over
        _same(loaded, found, lambda d: ROS1.deserialize_ros1(d, JOINT), ROWS)

    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-ros1-") as folder:
        for packing in (None, *Writer1.CompressionFormat):
            path = Path(folder) / "r.bag"
            path.unlink(missing_ok=True)
            write_ros1(path, packing, messages(ROS1, ROWS, seq=7), chunk=3000)
            out.join(judged(o, NIGHT // 3, path, _read, compare))
    return out
