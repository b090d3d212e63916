# SPDX-License-Identifier: Apache-2.0
"""The recorder's MCAP file beside the writer of the `mcap` package: processor time per message,
what a killed recorder leaves, and what a full disk leaves.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from io import FileIO
from pathlib import Path

from mcap.reader import McapReader, NonSeekingReader, SeekingReader
from mcap.writer import CompressionType, Writer

from flatplank_control.recording.bag_writer import CHUNK_SIZE, FLUSH_PERIOD
from flatplank_control.recording.mcap_file import McapFile

TOPICS = 11
"""topics of a bench in slip control at every cycle"""
RATE = 1000
"""bus cycles per second"""
SIZE = 160
"""of a message [bytes]; those of the table have 90 to 300"""
CYCLES = 20_000
FULL = 4 * 1024 * 1024
"""where the disk is full [bytes]"""
REPEATS = 5

Make = Callable[[FileIO], McapFile | Writer]


def own(stream: FileIO) -> McapFile:
    file = McapFile(stream)
    schema = file.add_schema("std_msgs/msg/String", "string data")
    for number in range(TOPICS):
        file.add_channel(f"/topic{number}", schema, {})
    return file


def package(stream: FileIO) -> Writer:
    file = Writer(stream, chunk_size=CHUNK_SIZE, compression=CompressionType.NONE)
    file.start("ros2")
    schema = file.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    for number in range(TOPICS):
        file.register_channel(f"/topic{number}", "cdr", schema)
    return file


def record(file: McapFile | Writer, cycles: int) -> None:
    """Record as the bench does: flush in each half second and at the size of a chunk."""
    data, every = bytes(SIZE), int(FLUSH_PERIOD * RATE)
    is_own = isinstance(file, McapFile)
    for cycle in range(1, cycles + 1):
        stamp = cycle * 1_000_000_000 // RATE
        for channel in range(1, TOPICS + 1):
            if is_own:
                file.add(channel, stamp, data, stamp)
                if file.pending >= CHUNK_SIZE:
                    file.flush()
            else:
                file.add_message(channel, stamp, data, stamp)
        if cycle % every == 0:
            file.flush()


def cost(make: Make, folder: Path) -> float:
    """Processor time per message, the best of some repeats [us]."""
    times = []
    for _ in range(REPEATS):
        with FileIO(folder / "cost.mcap", "wb") as stream:
            begin = time.process_time()
            file = make(stream)
            record(file, CYCLES)
            file.finish()
            times.append(time.process_time() - begin)
    return 1e6 * min(times) / (CYCLES * TOPICS)


def in_child(path: Path, work: Callable[[FileIO], None]) -> str:
    """Run in a process that may die; what it raised."""
    read, write = os.pipe()
    if os.fork() == 0:
        try:
            work(FileIO(path, "wb"))
        except Exception as error:
            os.write(write, f"{type(error).__name__}: {error}".encode())
        os._exit(0)
    os.close(write)
    os.wait()
    with os.fdopen(read) as told:
        return told.read()


def readable(path: Path) -> str:
    """What readers from front to end and by the summary get."""
    said = f"{path.stat().st_size} bytes; front to end {read_by(NonSeekingReader, path)}"
    return f"{said}; by the summary {read_by(SeekingReader, path)}"


def read_by(reader: type[McapReader], path: Path) -> str:
    count, end = 0, ""
    with path.open("rb") as stream:
        try:
            for _ in reader(stream).iter_messages(log_time_order=False):
                count += 1
        except Exception as error:  # the reader raises what the damage makes it raise
            end = f", then {type(error).__name__}"
    return f"{count} messages{end}"


def killed(make: Make, path: Path) -> str:
    """A recorder killed 0.4 s after its last flush, of 5.4 s."""

    def work(stream: FileIO) -> None:
        record(make(stream), int(5.4 * RATE))
        os.kill(os.getpid(), signal.SIGKILL)

    in_child(path, work)
    return f"of {int(5.4 * RATE) * TOPICS} messages: {readable(path)}"


def full(make: Make, path: Path) -> str:
    """A disk that takes no more; then the recorder frees its reserve and finishes."""

    def work(stream: FileIO) -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, hard))
        file = make(stream)
        try:
            record(file, CYCLES)
        except OSError:
            resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
            if isinstance(file, McapFile):
                file.drop_pending()
            file.finish()

    told = in_child(path, work)
    return readable(path) + (f"; finish: {told}" if told else "")


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, make in (("own file", own), ("mcap.Writer", package)):
            us = cost(make, folder)
            load = us * 1e-6 * RATE * TOPICS
            print(f"{what}: {us:.2f} us a message, {load:.1%} of a core at {RATE} Hz")
            print(f"  killed: {killed(make, folder / 'killed.mcap')}")
            print(f"  full disk: {full(make, folder / 'full.mcap')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
