# SPDX-License-Identifier: Apache-2.0
"""Nodes whose answer is due within the cycle go before other work of the computer."""

from __future__ import annotations

import subprocess
import sys

import pytest

from flatplank_control.bench.setup import BenchSetup

IN_LOOP = {
    "measurement_hub",
    "encoders",
    "wheel_drive",
    "free_rolling_controller",
    "slip_sequencer",
    "steer_drive",
    "steering_hold",
}
THREADS = """
import os, threading
from flatplank_hw.process import NOT_ALLOWED, prepare_threads
go = threading.Event()
threading.Thread(target=go.wait).start()
said = prepare_threads(7)
now = {os.sched_getscheduler(int(t)) for t in os.listdir("/proc/self/task")}
go.set()
assert (now, said) in (({os.SCHED_FIFO}, "SCHED_FIFO 7"), ({os.SCHED_OTHER}, NOT_ALLOWED))
"""


@pytest.mark.parametrize("kind", ["emulated", "lab"])
def test_the_loop_of_a_bus_of_frames_goes_first(kind: str) -> None:
    setup = BenchSetup(kind=kind, axes=("steer",))
    first = {node.name for node in setup.nodes() if setup.of(node).get("fifo_priority")}
    assert first == IN_LOOP | {"ethercat_bus"}


@pytest.mark.parametrize("pace", ["realtime", "hold", "lockstep"])
def test_a_simulated_bench_takes_its_turn(pace: str) -> None:
    setup = BenchSetup(pace=pace)
    assert not any(setup.of(node).get("fifo_priority") for node in setup.nodes())


def test_all_threads_of_a_node_or_none() -> None:
    subprocess.run([sys.executable, "-c", THREADS], check=True)
