# SPDX-License-Identifier: Apache-2.0
"""Records in many processes at 250 Hz until they are killed; says on stdout what was written.

Arguments: data folder, number of processes. Lines: process number, pid, cycle, stamp [ns].
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import rec_samples as samples

from flatplank_control.recording.session import RecordingSession

TIMEOUT_S = 30.0
"""a process that nobody kills ends by itself [s]"""


def record(folder: Path, number: int) -> None:
    session = RecordingSession(folder, samples.TOPICS)
    session.start(samples.toyo(fz=float(number)), time.monotonic_ns(), at_once=True)
    begin = time.monotonic()
    cycle = 0
    while time.monotonic() - begin < TIMEOUT_S:
        cycle += 1
        bus, wrench = samples.bus_bytes(cycle), samples.wrench_bytes(cycle)
        stamp_ns = time.monotonic_ns()
        session.write(samples.BUS, bus, stamp_ns)
        session.write(samples.WRENCH, wrench, stamp_ns)
        os.write(1, f"{number} {os.getpid()} {cycle} {stamp_ns}\n".encode())
        time.sleep(0.004)  # the pace of the bus


def main() -> None:
    folder, count = Path(sys.argv[1]), int(sys.argv[2])
    samples.bus_bytes(0), samples.wrench_bytes(0)
    for number in range(count):
        if os.fork() == 0:
            record(folder, number)
            os._exit(0)
    for _ in range(count):
        os.wait()


if __name__ == "__main__":
    main()
