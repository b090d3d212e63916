# SPDX-License-Identifier: Apache-2.0
"""Measures the graph in real time: lost cycles, and the delay of the drive's command."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import SetBool

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_msgs.srv import (
    PlankSwitch,
    SetOperationMode,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)
from lockstep import processor_s

CASES = ((250, 1, 60.0), (1000, 1, 30.0), (1000, 4, 30.0))
"""bus rate [Hz], cycles per message, wall time [s]"""


def run(rate_hz: int, batch: int, seconds: float) -> None:
    """Roll in slip control, record, and print the results."""
    seen: dict[str, str] = {}

    def note(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "/simulated_plant":
                seen.update((v.key, v.value) for v in status.values)

    with tempfile.TemporaryDirectory() as folder:
        setup = BenchSetup(pace="realtime", rate_hz=rate_hz, batch=batch, data=folder)
        with BenchProcesses(setup, log=Path(folder) / "nodes.log") as bench, BenchClient() as c:
            c.wait_connected(bench)
            c.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
            roll(c)
            wait(c, 1.5)
            before, begin, used = int(seen["skipped"]), time.monotonic(), processor_s(bench)
            wait(c, seconds)
            cores = (processor_s(bench) - used) / (time.monotonic() - begin)
            dropped = int(seen["skipped"]) - before
            done = c.call(StopRecording, "/recorder/stop", status="complete")
            wait(c, 1.5)
    print(f"real time at {rate_hz} Hz, {batch} cycles per message, for {seconds:g} s:")
    print(f"  processor: {cores:.2f} cores, recorded (wanted at 250 Hz: 0.25)")
    print(f"  cycles recorded {done.cycles_received}, lost {done.cycles_lost} (wanted: 0)")
    print(f"  messages that the bus itself dropped: {dropped} (wanted: 0; {before} at the start)")
    print(
        f"  drive command after its sample: p99 {seen['command age p99']} cycles, "
        f"max {seen['command age max']} (wanted: {2 * batch})"
    )


def roll(c: BenchClient) -> None:
    """Load the tire, enable the drive in slip control on a moving road, and record."""
    c.call(SetValue, "/simulated_plant/load_to", value=3700.0)
    wait(c, 12.0)
    c.call(
        SetWaveform, "/slip_sequencer/set_waveform", name="constant", parameters=["kappa"],
        values=[0.01], start_position=0.1, effective_rolling_radius=0.3108,
    )  # fmt: skip
    c.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
    c.call(SetBool, "/wheel_drive/enable", data=True)
    c.call(PlankSwitch, "/simulated_plant/plank", direction=1, fast=True, stop_at=float("nan"))
    c.call(StartRecording, "/recorder/start", name="rt", record="tire: TOY", at_once=True)


def main(seconds: float | None = None) -> None:
    os.environ.update(loopback_environment(), ROS_DOMAIN_ID=str(60 + os.getpid() % 40))
    for rate_hz, batch, usual in CASES:
        run(rate_hz, batch, seconds or usual)


def wait(client: BenchClient, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        client.spin(0.1)


if __name__ == "__main__":
    main(*(float(word) for word in sys.argv[1:]))
