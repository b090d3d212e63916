# SPDX-License-Identifier: Apache-2.0
"""Runs the whole graph on real EtherCAT frames, with an emulated bus strictly by the clock.

The bus does not wait for nodes: a command older than 44 ms stops the wheel, as on the machine.
Arguments: seconds, number of busy processes of ordinary priority beside it (0).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_msgs.msg import DriveStatus
from flatplank_msgs.srv import StopRecording
from realtime import roll, wait

COUNTS = ("sent", "received", "lost", "missed", "stale", "wrong_counter", "unread")


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Start `count` processes that each use a core, in separate sessions like the work of other
    users."""
    words = [sys.executable, "-c", "while True: pass"]
    burners = [subprocess.Popen(words, start_new_session=True) for _ in range(count)]
    try:
        yield
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


def main(seconds: float = 60.0, burners: int = 0) -> None:
    """Roll in slip control and record for `seconds` [s]."""
    os.environ.update(loopback_environment(), ROS_DOMAIN_ID=str(60 + os.getpid() % 40))
    seen: dict[str, str] = {}
    oldest: list[int] = []
    held: set[int] = set()

    def note(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "/ethercat_bus":
                seen.update((v.key, v.value) for v in status.values)
                oldest.append(int(seen["oldest_command_cycles"]))

    with tempfile.TemporaryDirectory() as folder:
        strict = {"ethercat_bus": {"wait_for_nodes": False}}
        setup = BenchSetup(kind="emulated", data=folder, parameters=strict)
        with BenchProcesses(setup, log=Path(folder) / "nodes.log") as bench, BenchClient() as c:
            c.wait_connected(bench)
            c.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
            roll(c)
            wait(c, 1.5)
            before, oldest[:] = {k: int(seen[k]) for k in COUNTS}, []
            c.node.create_subscription(
                DriveStatus, "/wheel_drive/status", lambda m: held.add(m.stop_reason), 2000
            )
            with busy(burners):
                wait(c, seconds)
                load = os.getloadavg()[0]
            done = c.call(StopRecording, "/recorder/stop", status="complete")
            wait(c, 1.5)
    counts = {k: int(seen[k]) - before[k] for k in COUNTS}
    print(
        f"EtherCAT frames at 250 Hz, strictly by the clock, {seconds:g} s, {burners} busy "
        f"processes beside it, load average {load:.1f}; bus process: {seen['scheduling']}"
    )
    print(f"  cycles recorded {done.cycles_received}, lost {done.cycles_lost} (wanted: 0)")
    print(
        f"  frames sent {counts['sent']}, received {counts['received']}, lost {counts['lost']}; "
        f"cycles that the computer missed {counts['missed']} (wanted: 0); images not read "
        f"{counts['unread']}; health at the end {seen['health']}"
    )
    print(f"  {times(seen, 'round_trip')}; {times(seen, 'cycle_time')}")
    print(f"  oldest command of any second: {max(oldest)} cycles (11 stop the wheel)")
    print(f"  stop reasons seen: {sorted(held - {0}) or 'none'} (wanted: none)")


def times(seen: dict[str, str], name: str) -> str:
    """Percentiles of a histogram of the bus process, since its start."""
    found = json.loads(seen[name].replace("'", '"'))
    return (
        f"{name.replace('_', ' ')} p50 {found['p50_us'] / 1e3:.2f}, "
        f"p99 {found['p99_us'] / 1e3:.2f}, max {found['worst_us'] / 1e3:.2f} ms"
    )


if __name__ == "__main__":
    main(*(float(word) for word in sys.argv[1:2]), *(int(word) for word in sys.argv[2:3]))
