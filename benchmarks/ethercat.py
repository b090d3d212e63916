# SPDX-License-Identifier: Apache-2.0
"""The whole graph on real EtherCAT frames, the emulated bus strictly by the clock.

Nothing waits for a node here: a command older than 44 ms stops the wheel, as on a machine.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from lockstep import LOOPBACK
from realtime import roll, wait

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_msgs.msg import DriveStatus
from flatplank_msgs.srv import StopRecording


def main(seconds: float = 60.0) -> None:
    """Rolls in slip control and records [s]."""
    os.environ.update(LOOPBACK, ROS_DOMAIN_ID=str(60 + os.getpid() % 40))
    seen: dict[str, str] = {}
    oldest: list[int] = []
    held: set[int] = set()

    def note(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "ethercat_bus":
                seen.update((v.key, v.value) for v in status.values)
                oldest.append(int(seen["oldest_command_cycles"]))

    with tempfile.TemporaryDirectory() as folder:
        strict = {"ethercat_bus": {"wait_for_nodes": False}}
        setup = BenchSetup(kind="emulated", data=folder, parameters=strict)
        with BenchProcesses(setup, log=Path(folder) / "nodes.log") as bench, BenchClient() as c:
            c.wait_connected(bench.running, timeout=60.0)
            c.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
            roll(c)
            wait(c, 1.5)
            before, oldest[:] = {k: int(seen[k]) for k in ("sent", "lost")}, []
            c.node.create_subscription(
                DriveStatus, "/wheel_drive/status", lambda m: held.add(m.stop_reason), 2000
            )
            wait(c, seconds)
            done = c.call(StopRecording, "/recorder/stop", status="complete")
            wait(c, 1.5)
    print(f"EtherCAT frames at 250 Hz, strictly by the clock, {seconds:g} s:")
    print(f"  cycles recorded {done.cycles_received}, lost {done.cycles_lost} (wanted: 0)")
    print(
        f"  frames sent {int(seen['sent']) - before['sent']}, "
        f"lost {int(seen['lost']) - before['lost']}, health at the end {seen['health']}"
    )
    print(f"  oldest command of any second: {max(oldest)} cycles (11 stop the wheel)")
    print(f"  stop reasons seen: {sorted(held - {0}) or 'none'} (wanted: none)")


if __name__ == "__main__":
    main(*(float(word) for word in sys.argv[1:]))
