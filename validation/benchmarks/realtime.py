# SPDX-License-Identifier: Apache-2.0
"""Measures the graph in real time: processor, lost and late cycles, and how late it wakes up and
answers, beside a bare loop that sleeps until each cycle. Graph and bare loop take turns, so that
their ratio does not depend on what else the machine does."""

from __future__ import annotations

import math
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import SetBool

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_hw.bus.histogram import SHARES, Histogram
from flatplank_hw.bus.timing import LATE, MADE
from flatplank_msgs.srv import (
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)
from lockstep import processor_s

CASES = ((250, 1, 60.0), (1000, 1, 40.0), (1000, 4, 40.0))
"""bus rate [Hz], cycles per message, wall time [s]"""
TURNS = 4
"""turns of graph and bare loop"""
Told = dict[str, str]


class Bare(NamedTuple):
    """A bare loop: how late it woke up, and how often by more than its period."""

    wake_up: Histogram
    late: int


Turn = tuple[Told, Bare, float]
"""what the bench told, the bare loop after it, and processor time [cores]"""


def run(rate_hz: int, batch: int, seconds: float) -> None:
    """Roll in slip control, record, and print the results."""
    seen: Told = {}

    def note(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "/simulated_plant":
                seen.clear()
                seen.update((v.key, v.value) for v in status.values)

    with tempfile.TemporaryDirectory() as folder:
        setup = BenchSetup(pace="realtime", rate_hz=rate_hz, batch=batch, data=folder)
        with BenchProcesses(setup, log=Path(folder) / "nodes.log") as bench, BenchClient() as c:
            c.wait_connected(bench)
            c.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
            roll(c)
            turns: list[Turn] = []
            for _ in range(TURNS):
                c.call(SetPace, "/simulated_plant/set_pace", pace="realtime", batch=batch)
                begin, used = time.monotonic(), processor_s(bench)
                wait(c, seconds / TURNS)
                cores = (processor_s(bench) - used) / (time.monotonic() - begin)
                told = dict(seen)
                c.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=batch)
                turns.append((told, bare_loop(batch / rate_hz, seconds / TURNS), cores))
            done = c.call(StopRecording, "/recorder/stop", status="complete")
    said = f"{batch} cycles per message, {TURNS} turns of {seconds / TURNS:g} s"
    print(f"real time at {rate_hz} Hz, {said}:")
    show(turns)
    print(f"  cycles recorded {done.cycles_received}, lost {done.cycles_lost} (wanted: 0)")


def show(turns: list[Turn]) -> None:
    """Print the medians over the turns, and the sums of what was counted."""
    cores = statistics.median(cores for *_, cores in turns)
    print(f"  processor: {cores:.2f} cores, recorded (wanted at 250 Hz: 0.25)")
    made, late = (sum(int(told[key]) for told, *_ in turns) for key in (MADE, LATE))
    print(f"  cycles made {made}, later than a period {late} ({100.0 * late / made:.2f} %)")
    waits, late = sum(b.wake_up.total for _, b, _ in turns), sum(b.late for _, b, _ in turns)
    share = 100.0 * late / waits
    print(f"  bare loop: wake-ups {waits}, later than a period {late} ({share:.2f} %)")
    ages = max(int(told["command age max"]) for told, *_ in turns)
    usual = max(int(told["command age p99"]) for told, *_ in turns)
    print(
        f"  drive command after its sample: p99 {usual} cycles, max {ages} (wanted: one message)"
    )
    print(f"  {'':20s}" + "".join(f"{label:>9s}" for label in SHARES) + "  [us]")
    for name in ("wake-up", "stamp to command", "frame to frame"):
        values = [median_us(turns, f"{name} {label} [us]") for label in SHARES]
        print(f"  {name:20s}" + "".join(f"{value:9.0f}" for value in values))
    bare = [
        statistics.median(loop.wake_up.percentile_us(share) for _, loop, _ in turns)
        for share in SHARES.values()
    ]
    print(f"  {'bare loop, wake-up':20s}" + "".join(f"{value:9.0f}" for value in bare))
    ratios = [
        float(told["wake-up p99.9 [us]"]) / loop.wake_up.percentile_us(SHARES["p99.9"])
        for told, loop, _ in turns
    ]
    print(
        f"  wake-up p99.9 over that of the bare loop: {statistics.median(ratios):.1f} "
        f"({min(ratios):.1f} to {max(ratios):.1f}; wanted: 3)"
    )


def median_us(turns: list[Turn], key: str) -> float:
    """Median over the turns [us]; those in which the drive was stopped tell of no commands."""
    told_us = [float(told[key]) for told, *_ in turns if key in told]
    return statistics.median(told_us) if told_us else math.nan


def bare_loop(period: float, seconds: float) -> Bare:
    """How late a loop wakes up that does nothing but sleep until each cycle; `period` [s]."""
    wake_up, late, due = Histogram(), 0, time.monotonic()
    end = due + seconds
    while due < end:
        due += period
        time.sleep(max(due - time.monotonic(), 0.0))
        after = time.monotonic() - due
        wake_up.add(round(after * 1e9))
        late += after > period
    return Bare(wake_up, late)


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
