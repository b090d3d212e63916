# SPDX-License-Identifier: Apache-2.0
"""Compares the bench in lockstep with the same graph without cores, in one run: cycles per second
and ratio.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from std_srvs.srv import SetBool

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_msgs.srv import (
    Advance,
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetValue,
    SetWaveform,
    StartRecording,
)

ROLES = ("hub", "encoders", "sequencer", "controller", "drive", "recorder", "runner")
BARE = Path(__file__).with_name("nodes") / "bare_graph.py"


def bare_rate(cycles: int, executor: str, domain: int) -> float:
    """Rounds per second of the bare graph."""
    env = {**os.environ, **loopback_environment(), "ROS_DOMAIN_ID": str(domain)}
    command = [sys.executable, str(BARE)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": env}
    others = [subprocess.Popen([*command, role, executor], **quiet) for role in ROLES]
    try:
        bus = subprocess.Popen(
            [*command, "bus", executor, str(cycles)], stdout=subprocess.PIPE, text=True, env=env
        )
        line = bus.stdout.readline()
        bus.kill()
        bus.wait()
    finally:
        for process in others:
            process.kill()
            process.wait()
    return float(line.split()[1])


def bench_rate(cycles: int, domain: int) -> float:
    """Bus cycles per second of the bench in slip control over a moving road, recording."""
    os.environ.update(loopback_environment(), ROS_DOMAIN_ID=str(domain))
    with tempfile.TemporaryDirectory() as folder:
        setup = BenchSetup(pace="hold", data=folder)
        log = Path(folder) / "nodes.log"
        with BenchProcesses(setup, log=log) as bench, BenchClient() as client:
            client.wait_connected(bench)
            return _rolling(client, cycles)


def _rolling(client: BenchClient, cycles: int) -> float:
    plant = "/simulated_plant"

    def advance(n: int) -> None:
        client.call(Advance, f"{plant}/advance", timeout=120.0, cycles=n)

    client.call(SetPace, f"{plant}/set_pace", pace="hold", batch=10)
    advance(100)
    client.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="position")
    client.call(SetValue, f"{plant}/load_to", value=3700.0)
    advance(6000)
    client.call(
        SetWaveform, "/slip_sequencer/set_waveform", name="step", parameters=["kappa"],
        values=[0.05], start_position=0.1, effective_rolling_radius=0.3108,
    )  # fmt: skip
    client.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
    client.call(SetBool, "/wheel_drive/enable", data=True)
    client.call(
        StartRecording, "/recorder/start", name="benchmark", record="tire: TOY", at_once=True
    )
    client.call(PlankSwitch, f"{plant}/plank", direction=1, fast=True, stop_at=float("nan"))
    client.call(SetPace, f"{plant}/set_pace", pace="hold", batch=1)
    advance(cycles // 10)
    begin = time.perf_counter()
    advance(cycles)
    return cycles / (time.perf_counter() - begin)


def main(cycles: int = 3000, repeats: int = 2) -> None:
    domain = 60 + os.getpid() % 20
    print(f"lock-stepped graph, {cycles} cycles, {repeats} times, best of each")
    bare, ours = 0.0, 0.0
    for _ in range(repeats):
        bare = max(bare, bare_rate(cycles, "default", domain))
        ours = max(ours, bench_rate(cycles, domain + 20))
    print(f"bare rclpy graph {bare:8.1f} cycles/s")
    print(f"bench            {ours:8.1f} cycles/s")
    print(f"ratio            {ours / bare:8.2f} (wanted: 0.7)")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
