# SPDX-License-Identifier: Apache-2.0
"""Time and memory of the import of one large bag of another bench: joints and wrench at 1 kHz.

python -m flatplank_validation.fits.large_bag --gigabytes 2
"""

from __future__ import annotations

import resource
import struct
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from flatplank_data.bags.topics import topic_map
from flatplank_data.readers.bag import import_bag
from flatplank_validation.fits.command import command

TOPICS = {
    "/joints": {"plank_position": "position[0]", "wheel_angle": "position[1]"},
    "/wrench": {"fx": "wrench.force.x", "fy": "wrench.force.y", "fz": "wrench.force.z"},
}
PERIOD = 1_000_000
"""time between two messages of a topic [ns]"""
STAMP = 4
"""place of the header's stamp in CDR [bytes]"""


def _payloads() -> dict[str, tuple[str, str, bytearray, int]]:
    """Topic -> type, definition, a message, and the place of its first number [bytes]."""
    store = get_typestore(Stores.ROS2_JAZZY)
    t = store.types
    header = t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](0, 0), "contact")
    vector, mark = t["geometry_msgs/msg/Vector3"], 1.2345e-300
    two, none = np.array([mark, 0.0]), np.zeros(0)
    wrench = t["geometry_msgs/msg/Wrench"](vector(mark, 0.0, 3700.0), vector(0.0, 0.0, 0.0))
    found = {}
    for topic, kind, message in (
        ("/joints", "sensor_msgs/msg/JointState",
         t["sensor_msgs/msg/JointState"](header, ["plank", "wheel"], two, two, none)),
        ("/wrench", "geometry_msgs/msg/WrenchStamped",
         t["geometry_msgs/msg/WrenchStamped"](header, wrench)),
    ):  # fmt: skip
        data = bytearray(store.serialize_cdr(message, kind))
        text = store.generate_msgdef(kind, ros_version=2)[0]
        found[topic] = kind, text, data, data.index(struct.pack("<d", mark))
    return found


def write(path: Path, size: float) -> int:
    """Write a bag of about `size` bytes, in chunks of 4 MB; returns its rows."""
    row, payloads, channels = 0, _payloads(), {}
    with open(path, "wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, chunk_size=4 << 20)
        writer.start(profile="ros2")
        for topic, (kind, text, _, _) in payloads.items():
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        while row % 1000 or stream.tell() < size:
            now = row * PERIOD
            for topic, (_, _, data, place) in payloads.items():
                struct.pack_into("<iI", data, STAMP, now // 10**9, now % 10**9)
                struct.pack_into("<d", data, place, 1e-6 * row)
                writer.add_message(channels[topic], now, bytes(data), now)
            row += 1
        writer.finish()
    return row


def _import(path: Path) -> tuple[int, float, float]:
    """Rows, time [s], and memory beyond that of the program [MB]."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.perf_counter()
    found = import_bag(path, topic_map({"topics": TOPICS})).columns
    spent = time.perf_counter() - begin
    if not np.array_equal(found["fx"], 1e-6 * np.arange(len(found["fx"]))):
        raise AssertionError("the rows are not those that were written")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return len(found["fx"]), spent, (most - before) / 1024.0


def measure(gigabytes: float = 2.0) -> dict[str, float]:
    """Size, rows, time and memory; the bag lies in the folder for temporary files meanwhile."""
    with tempfile.TemporaryDirectory(prefix="flatplank-") as folder:
        path = Path(folder) / "large.mcap"
        written = write(path, gigabytes * 1e9)
        size = path.stat().st_size
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            rows, spent, memory = pool.submit(_import, path).result()
    if rows != written:
        raise AssertionError(f"{rows} rows of {written}")
    return {
        "size_gb": size / 1e9,
        "rows": rows,
        "time_s": spent,
        "gb_per_minute": 60e-9 * size / spent,
        "memory_mb": memory,
        "memory_over_size": memory * 2**20 / size,
    }


main = command(__doc__, lambda chosen: measure(chosen.gigabytes), gigabytes=2.0)

if __name__ == "__main__":
    main()
