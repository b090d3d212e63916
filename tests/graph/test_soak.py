# SPDX-License-Identifier: Apache-2.0
"""The bench does not slow down and does not grow: slip runs to and fro, as the thesis's software
could make them for 30 to 45 minutes before it had to be started anew."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from bench_graph import Graph, graph
from rclpy.task import Task
from std_srvs.srv import SetBool, Trigger

from flatplank_data.run_record import load_record
from flatplank_msgs.srv import (
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetValue,
    SetWaveform,
    StartRecording,
)

pytestmark = pytest.mark.graph
RATE = 250
CHUNK = 10 * RATE
"""cycles between two looks"""
FORWARD, BACK = 130, 140
"""of a pass [s]"""
MORE_MEMORY = 8.0
"""of a node after its first look [MB]; a recording's buffers come and go"""
SLOWER = 1.6
"""CPU time per cycle of all nodes, late against early: a busy machine's caches change it too"""


class Look(NamedTuple):
    """At one moment."""

    cycle: int
    memory: dict[str, float]
    """of each node [MB]"""
    cpu: float
    """of all nodes [s]"""


def look(bench: Graph, cycle: int) -> Look:
    page, tick = os.sysconf("SC_PAGE_SIZE"), os.sysconf("SC_CLK_TCK")
    memory, cpu = {}, 0.0
    for name, process in bench.processes.running.items():
        with open(f"/proc/{process.pid}/statm", encoding="ascii") as file:
            memory[name] = int(file.read().split()[1]) * page / 1e6
        with open(f"/proc/{process.pid}/stat", encoding="ascii") as file:
            words = file.read().rsplit(")", 1)[1].split()
        cpu += (int(words[11]) + int(words[12])) / tick
    return Look(cycle, memory, cpu)


def advance(bench: Graph, seconds: float) -> Iterator[Look]:
    for _ in range(round(seconds * RATE / CHUNK)):
        yield look(bench, bench.advance(CHUNK, timeout=300.0))


def one_pass(bench: Graph, number: int) -> Iterator[Look]:
    """Load, a recorded slip run over the road, unload, back."""
    call = bench.call

    def plank(direction: int) -> None:
        call(PlankSwitch, "/simulated_plant/plank", direction=direction, fast=True,
             stop_at=float("nan"))  # fmt: skip

    call(SetValue, "/simulated_plant/load_to", value=3700.0)
    yield from advance(bench, 10.0)
    call(
        SetWaveform, "/slip_sequencer/set_waveform", name="step", parameters=["kappa"],
        values=[0.02], start_position=0.5, effective_rolling_radius=0.3108,
    )  # fmt: skip
    call(Trigger, "/encoders/arm")
    call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
    call(SetBool, "/wheel_drive/enable", data=True)
    call(StartRecording, "/recorder/start", name=f"soak_{number}", record="tire: TOY")
    plank(1)
    yield from advance(bench, FORWARD)
    plank(0)
    bench.advance(RATE)
    call(SetBool, "/wheel_drive/enable", data=False)
    bench.stop_recording()
    call(Trigger, "/simulated_plant/unload")
    yield from advance(bench, 10.0)
    plank(-1)
    yield from advance(bench, BACK)
    plank(0)


def soak(bench: Graph, seconds: float, capsys) -> list[Look]:
    """Passes until so much bench time [s] has gone, a line each."""
    call = bench.call
    call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=10)
    bench.advance(100)
    looks, number, before = [], 0, tasks()
    while not looks or looks[-1].cycle < seconds * RATE:
        number += 1
        looks += one_pass(bench, number)
        minutes, memory = looks[-1].cycle / RATE / 60, sum(looks[-1].memory.values())
        with capsys.disabled():
            print(f"{minutes:6.1f} of {seconds / 60:.0f} min, {memory:.1f} MB", flush=True)
    # nor does who asks the bench get slower: no message leaves a task behind
    assert tasks() < before + 10
    for k in range(1, number + 1):
        assert load_record(bench.data / f"soak_{k}").cycles_lost == 0
    return looks


def tasks() -> int:
    """That the executors of this process still have to do, or remember."""
    return sum(isinstance(o, Task) for o in gc.get_objects())


def pace(looks: list[Look]) -> float:
    """CPU time per bus cycle [us]."""
    return 1e6 * (looks[-1].cpu - looks[0].cpu) / (looks[-1].cycle - looks[0].cycle)


def judge(looks: list[Look], capsys) -> None:
    """Early and late, by thirds behind the first pass of each kind of work."""
    third = max(len(looks) // 3, 2)
    early, late = looks[:third], looks[-third:]
    growth = {n: late[-1].memory[n] - early[-1].memory[n] for n in early[-1].memory}
    with capsys.disabled():
        minutes = looks[-1].cycle / RATE / 60
        print(f"\n{minutes:.0f} min of bench time: CPU time per cycle {pace(early):.0f} us in the "
              f"first third, {pace(late):.0f} us in the last")  # fmt: skip
        for name, value in growth.items():
            print(f"  {name:24} {late[-1].memory[name]:6.1f} MB, {value:+.2f} MB")
    assert max(growth.values()) < MORE_MEMORY
    # recording costs more than returning: the same kind of work is compared
    assert pace(late) < SLOWER * max(pace(early), pace(looks))


@pytest.mark.long
def test_five_minutes(tmp_path, monkeypatch, capsys):
    with graph(tmp_path, monkeypatch) as bench:
        looks = soak(bench, 300.0, capsys)
    judge(looks, capsys)


@pytest.mark.long
@pytest.mark.timeout(6 * 3600)
def test_ten_hours(tmp_path, monkeypatch, capsys):
    with graph(tmp_path, monkeypatch) as bench:
        looks = soak(bench, float(os.environ.get("FLATPLANK_SOAK_HOURS", "10")) * 3600.0, capsys)
    judge(looks, capsys)
