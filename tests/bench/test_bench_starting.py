# SPDX-License-Identifier: Apache-2.0
"""Waiting for the nodes of a bench follows the nodes, not the clock."""

from __future__ import annotations

import fcntl
import signal
import time
from pathlib import Path

import pytest

from flatplank_control.bench.fast_dds import remove_orphans
from flatplank_control.bench.processes import (
    RUNAWAY_CPU_S,
    BenchProcesses,
    ProcessState,
    StartProgress,
)
from flatplank_control.bench.setup import EVERY_NODE, BenchSetup

NAMES = ("encoders", "recorder")
LOADING = ProcessState("S", 0.0, False)


def test_as_long_as_a_node_uses_the_processor_nobody_gives_up() -> None:
    start = StartProgress(NAMES, 0.0, stall_s=30.0)
    start.register_answer("encoders", "", 1.0)
    for i in range(1000):
        vitals = {"recorder": ProcessState("S", 0.02 * i, False)}
        assert not start.why_waiting_is_useless(vitals, 10.0 * i)


@pytest.mark.parametrize("state", ["R", "D"])
def test_a_node_that_waits_for_processor_or_disk_gets_on(state: str) -> None:
    start = StartProgress(NAMES, 0.0, stall_s=30.0)
    assert not start.why_waiting_is_useless({"recorder": ProcessState(state, 0.0, False)}, 1000.0)


@pytest.mark.parametrize(
    ("seen", "words"),
    [
        (LOADING, "recorder hangs before the node is created"),
        (ProcessState("T", 0.1, False), "recorder is stopped"),
        (ProcessState("S", 50.0, True), "recorder runs, but its services are not heard"),
        (None, "recorder does not answer; is the bench running?"),
    ],
)
def test_a_node_that_hangs_is_named_with_what_it_hangs_on(seen: ProcessState, words: str) -> None:
    start = StartProgress(NAMES, 0.0, stall_s=30.0)
    start.register_answer("encoders", "", 1.0)
    vitals = {"recorder": seen} if seen else {}
    start.why_waiting_is_useless(vitals, 2.0)
    assert not start.why_waiting_is_useless(vitals, 31.0)
    told = start.why_waiting_is_useless(vitals, 33.0)
    assert told.startswith(words)
    assert "1 of 2 nodes are up" in told


def test_what_a_node_waits_for_is_told() -> None:
    start = StartProgress(NAMES, 0.0, stall_s=30.0)
    start.register_answer("recorder", "no partner on /bus/inputs", 5.0)
    start.register_answer("recorder", "no partner on /bus/inputs", 20.0)
    told = start.why_waiting_is_useless({"recorder": ProcessState("S", 9.0, True)}, 36.0)
    assert "recorder waits: no partner on /bus/inputs" in told


def test_a_node_that_works_for_ever_does_not_come_up() -> None:
    start = StartProgress(NAMES, 0.0)
    busy = {"recorder": ProcessState("R", RUNAWAY_CPU_S + 1.0, False)}
    assert start.why_waiting_is_useless(busy, 1.0).startswith(
        "recorder: not up after 601 s of processor time"
    )


def test_everybody_up() -> None:
    start = StartProgress(NAMES, 0.0)
    for name in NAMES:
        start.register_answer(name, "", 1.0)
    assert start.missing == []
    assert str(start) == "2 of 2 nodes are up"


def processes(tmp_path: Path, names: set[str], **environment: str) -> BenchProcesses:
    setup = BenchSetup(pace="hold", data=str(tmp_path), separate=(EVERY_NODE,))
    others = frozenset(node.name for node in setup.nodes()) - names
    log = tmp_path / "nodes.log"
    return BenchProcesses(setup, log=log, without=others, environment=environment)


def wait(condition, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_node_that_died_is_told_with_its_last_words(tmp_path: Path) -> None:
    (tmp_path / "flatplank_hw").mkdir()
    (tmp_path / "flatplank_hw" / "__init__.py").write_text("raise OSError('no such luck')\n")
    with processes(tmp_path, {"encoders"}, PYTHONPATH=str(tmp_path)) as bench:
        wait(bench.why_ended)
        assert bench.why_ended().startswith(
            "encoders ended by itself (exit code 1): OSError: no such luck ("
        )


def test_the_last_words_are_those_of_the_node_itself(tmp_path: Path) -> None:
    with processes(tmp_path, {"encoders", "recorder"}) as bench:
        for node in bench.running.values():
            node.kill()
        wait(lambda: len(bench.ended()) == 2)
        (tmp_path / "nodes.log").write_text(
            "[INFO] [1.0] [encoders]: first\n[ERROR] [2.0] [recorder]: disk\nlast\n"
        )
        recorder, encoders = sorted(bench.why_ended().split("; "), reverse=True)
        assert "recorder ended by itself (killed by SIGKILL): [ERROR] [2.0] [recorder]" in recorder
        assert "encoders ended by itself (killed by SIGKILL): [INFO] [1.0] [encoders]" in encoders


def test_a_start_that_is_given_up_leaves_nothing(tmp_path: Path) -> None:
    """Nodes in the midst of loading, one of them stopped, are gone within the time of grace."""
    with processes(tmp_path, {"encoders", "recorder"}) as bench:
        nodes = list(bench.running.values())
        nodes[0].send_signal(signal.SIGSTOP)
        wait(lambda: bench.vitals()["encoders"].state == "T" or nodes[0].poll() is None)
    assert all(node.poll() is not None for node in nodes)
    assert not bench.running
    assert "Traceback" not in (tmp_path / "nodes.log").read_text()


def test_shared_memory_of_the_dead_is_removed_and_that_of_the_living_is_not(tmp_path) -> None:
    for name in ("fastrtps_dead", "fastrtps_dead_el", "fastrtps_alive", "fastrtps_alive_el"):
        (tmp_path / name).write_bytes(b"")
    for name in ("fastrtps_port7", "fastrtps_port7_el", "fastrtps_port7_sl"):
        (tmp_path / name).write_bytes(b"")
    for name in ("fastrtps_port8", "fastrtps_port8_el", "sem.fastrtps_port8_mutex"):
        (tmp_path / name).write_bytes(b"")
    alive = (tmp_path / "fastrtps_alive_el").open("rb")
    sharing = (tmp_path / "fastrtps_port7_sl").open("rb")
    with alive, sharing:
        fcntl.flock(alive, fcntl.LOCK_EX)
        fcntl.flock(sharing, fcntl.LOCK_SH)
        assert remove_orphans(tmp_path) == ["fastrtps_dead", "fastrtps_port8"]
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "fastrtps_alive",
        "fastrtps_alive_el",
        "fastrtps_port7",
        "fastrtps_port7_el",
        "fastrtps_port7_sl",
    ]
