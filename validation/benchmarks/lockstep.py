# SPDX-License-Identifier: Apache-2.0
"""Cost of the held bench in one run: its nodes in one process, each in a process of its own, and
the same graph without cores.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from std_srvs.srv import SetBool

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import EVERY_NODE, BenchSetup
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


class Cost(NamedTuple):
    """Cost of a bus cycle in slip control over a moving road, recorded or not."""

    cycles_per_s: float
    processor_ms: float


def bench_cost(cycles: int, domain: int, separate: tuple[str, ...], recorded: bool) -> Cost:
    """Cost with the recorder, or without recorder and runner."""
    os.environ.update(loopback_environment(), ROS_DOMAIN_ID=str(domain))
    without = frozenset() if recorded else frozenset({"recorder", "measurement_runner"})
    with tempfile.TemporaryDirectory() as folder:
        setup = BenchSetup(pace="hold", data=folder, separate=separate)
        log = Path(folder) / "nodes.log"
        with BenchProcesses(setup, log=log, without=without) as bench, BenchClient() as client:
            client.wait_connected(bench)
            return _rolling(client, bench, cycles, recorded)


def processor_s(bench: BenchProcesses) -> float:
    """Processor time of all processes so far [s]."""
    return sum({bench.nodes()[n]: state.cpu_s for n, state in bench.vitals().items()}.values())


def _rolling(client: BenchClient, bench: BenchProcesses, cycles: int, recorded: bool) -> Cost:
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
    if recorded:
        client.call(
            StartRecording, "/recorder/start", name="benchmark", record="tire: TOY", at_once=True
        )
    client.call(PlankSwitch, f"{plant}/plank", direction=1, fast=True, stop_at=float("nan"))
    client.call(SetPace, f"{plant}/set_pace", pace="hold", batch=1)
    advance(cycles // 10)
    begin, used = time.perf_counter(), processor_s(bench)
    advance(cycles)
    used, wall = processor_s(bench) - used, time.perf_counter() - begin
    return Cost(cycles / wall, 1e3 * used / cycles)


CASES = {
    "one process": ((), False),
    "one process, recorded": ((), True),
    "eight processes": ((EVERY_NODE,), False),
    "eight processes, recorded": ((EVERY_NODE,), True),
}
"""case -> nodes with a process of their own, and whether the bench records"""
WANTED_MS = {"one process": 0.6, "one process, recorded": 0.9}


def main(cycles: int = 3000, repeats: int = 2) -> None:
    domain = 60 + os.getpid() % 20
    print(f"held bench in slip control, {cycles} cycles, {repeats} times in turn, best of each")
    bare, best = 0.0, dict.fromkeys(CASES, Cost(0.0, math.inf))
    for _ in range(repeats):
        bare = max(bare, bare_rate(cycles, "default", domain))
        for name, (separate, recorded) in CASES.items():
            cost = bench_cost(cycles, domain + 20, separate, recorded)
            best[name] = min(best[name], cost, key=lambda c: c.processor_ms)
    print(f"{'bare rclpy graph':28}{bare:8.0f} cycles/s")
    for name, cost in best.items():
        goal = f"  (wanted: {WANTED_MS[name]} ms)" if name in WANTED_MS else ""
        print(f"{name:28}{cost.cycles_per_s:8.0f} cycles/s{cost.processor_ms:8.2f} ms of processor"
              f" per cycle{goal}")  # fmt: skip
    for recorded in ("", ", recorded"):
        one, eight = best[f"one process{recorded}"], best[f"eight processes{recorded}"]
        processor = eight.processor_ms / one.processor_ms
        rate = one.cycles_per_s / eight.cycles_per_s
        print(
            f"one process{recorded}: {processor:.1f} times less processor, {rate:.1f} times faster"
        )


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
