# SPDX-License-Identifier: Apache-2.0
"""Bags of another bench, written by other programs; and a reader of ROS 1 bags of its own."""

from __future__ import annotations

import bz2
import sqlite3
import struct
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Writer1
from rosbags.typesys import Stores, get_typestore

ROWS, PERIOD, START = 400, 10**8, 1_700_000_000 * 10**9
JOINT, WRENCH = "sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"
TOPICS = {
    "/enc": {"plank_position": "position[0]", "wheel_angle": "position[1]"},
    "/hub": {"fx": "wrench.force.x", "fz": "wrench.force.z"},
}
STORE = get_typestore(Stores.ROS2_JAZZY)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
Message = tuple[str, str, int, Any]
"""topic, type, time [ns], message or its bytes"""


def messages(store=STORE, rows: int = ROWS, **more) -> Iterator[Message]:
    """The values of a message tell the number of its row."""
    t = store.types
    vector = t["geometry_msgs/msg/Vector3"]
    for i in range(rows):
        at = START + i * PERIOD
        stamp = t["builtin_interfaces/msg/Time"](at // 10**9, at % 10**9)
        header = t["std_msgs/msg/Header"](stamp=stamp, frame_id="", **more)
        places = np.array([1e-3 * i, 2e-3 * i])
        none = np.zeros(0)
        yield "/enc", JOINT, at, t[JOINT](header, ["plank", "wheel"], places, none, none)
        force = t["geometry_msgs/msg/Wrench"](vector(float(i), 0.0, 3700.0), vector(0.0, 0.0, 0.0))
        yield "/hub", WRENCH, at, t[WRENCH](header, force)


def plain(store=STORE, rows: int = ROWS) -> Iterator[Message]:
    """The messages in CDR."""
    for topic, kind, at, message in messages(store, rows):
        yield topic, kind, at, bytes(store.serialize_cdr(message, kind))


def definition(kind: str) -> str:
    """Definition of a type as `.msg` text."""
    return STORE.generate_msgdef(kind, ros_version=2)[0]


def create(path: Path, mode: str) -> sqlite3.Connection:
    """A database as rosbag2 makes it; mode: of the journal."""
    base = sqlite3.connect(path, isolation_level=None)
    base.execute(f"PRAGMA journal_mode={mode}")
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT)")
    base.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
        "data BLOB)"
    )
    for number, (topic, kind) in enumerate((("/enc", JOINT), ("/hub", WRENCH)), start=1):
        base.execute("INSERT INTO topics VALUES(?,?,?)", (number, topic, kind))
    return base


def insert(base: sqlite3.Connection, first: int, last: int) -> None:
    """The messages of rows first to last, without the last, in one transaction."""
    base.execute("BEGIN")
    rows = [(1 + (topic == "/hub"), at, data) for topic, _, at, data in plain()]
    base.executemany(
        "INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", rows[2 * first : 2 * last]
    )


def write_mcap(
    path: Path, rows: Iterable[Message], language: str = "ros2msg",
    text: Callable[[str], str] = definition, coding: str = "cdr", **options,
) -> Path:  # fmt: skip
    """An MCAP file by the package `mcap`."""
    with open(path, "wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        channels: dict[str, int] = {}
        for topic, kind, at, payload in rows:
            if topic not in channels:
                schema = writer.register_schema(kind, language, text(kind).encode())
                channels[topic] = writer.register_channel(topic, coding, schema)
            writer.add_message(channels[topic], at, payload, at)
        writer.finish()
    return path


def as_a_stream(path: Path) -> Path:
    """The file packed block by block, as rosbag2 does."""
    packer, data = zstandard.ZstdCompressor(write_checksum=True).compressobj(), path.read_bytes()
    parts = []
    for at in range(0, len(data), 4096):
        parts += [packer.compress(data[at : at + 4096])]
        parts += [packer.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)]
    packed = path.with_name(f"{path.name}.zstd")
    packed.write_bytes(b"".join(parts) + packer.flush())
    path.unlink()
    return packed


def write_ros1(
    path: Path, packing: Writer1.CompressionFormat | None = None,
    rows: Iterable[Message] | None = None, chunk: int = 1 << 20,
) -> Path:  # fmt: skip
    """A bag of ROS 1 by `rosbags`; chunk: size of a chunk [bytes]."""
    writer = Writer1(path)
    writer.chunk_threshold = chunk
    if packing:
        writer.set_compression(packing)
    with writer:
        channels: dict[str, Any] = {}
        for topic, kind, at, message in rows or messages(ROS1, seq=7):
            if topic not in channels:
                channels[topic] = writer.add_connection(topic, kind, typestore=ROS1)
            data = message if isinstance(message, bytes) else ROS1.serialize_ros1(message, kind)
            writer.write(channels[topic], at, data)
    return path


UNPACK = {b"none": bytes, b"bz2": bz2.decompress, b"lz4": lz4.frame.decompress}


def records_of_ros1(data: bytes) -> Iterator[tuple[dict[bytes, bytes], bytes]]:
    """Header and data of each record of format 2.0, one after the other, without the index."""
    at = 0
    while at < len(data):
        parts = []
        for _ in range(2):
            (size,) = struct.unpack_from("<I", data, at)
            if at + 4 + size > len(data):
                raise struct.error("a record is cut short")
            parts.append(data[at + 4 : at + 4 + size])
            at += 4 + size
        head, fields = parts[0], {}
        while head:
            (size,) = struct.unpack_from("<I", head)
            key, _, value = head[4 : 4 + size].partition(b"=")
            fields[key], head = value, head[4 + size :]
        yield fields, parts[1]


def messages_of_ros1(data: bytes) -> dict[str, list[bytes]]:
    """Topic -> messages, in the order of the file."""
    topics: dict[bytes, str] = {}
    found: dict[str, list[bytes]] = {}
    for fields, body in records_of_ros1(data.split(b"\n", 1)[1]):
        if fields[b"op"] != b"\x05":  # a chunk
            continue
        for inner, message in records_of_ros1(UNPACK[fields[b"compression"]](body)):
            if inner[b"op"] == b"\x07":
                topics[inner[b"conn"]] = inner[b"topic"].decode()
            elif inner[b"op"] == b"\x02":
                found.setdefault(topics[inner[b"conn"]], []).append(message)
    return found
