# SPDX-License-Identifier: Apache-2.0
"""A bench starts from nothing and beside other work; one that is given up leaves nothing."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import pytest
from domains import loopback, next_domain

from flatplank_control.bench.fast_dds import SHARED_MEMORY
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import EVERY_NODE, BenchSetup
from flatplank_control.nodes.client import BenchClient, BenchError
from flatplank_validation.bench.cold_start import busy, forget_files, without_byte_code

pytestmark = [pytest.mark.graph, pytest.mark.timeout(900)]


def bench_in(folder: Path, **environment: str) -> BenchProcesses:
    folder.mkdir(parents=True, exist_ok=True)
    setup = BenchSetup(pace="hold", data=str(folder / "data"), separate=(EVERY_NODE,))
    return BenchProcesses(setup, environment=environment, log=folder / "nodes.log")


def use(monkeypatch: pytest.MonkeyPatch, domain: int) -> dict[str, str]:
    """This process and those that it starts are in a domain of their own."""
    environment = loopback(domain)
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    return environment


def codes(nodes: list[subprocess.Popen]) -> set[int | tuple[str, int | None]]:
    """Exit codes; of a node that did not end well its name, too."""
    return {node.poll() and (node.args[2], node.poll()) for node in nodes}


def start(bench: BenchProcesses) -> list[str]:
    """Start the nodes; what was said meanwhile."""
    said: list[str] = []
    bench.start()
    with BenchClient() as client:
        client.wait_connected(bench, say=said.append)
    return said


@pytest.mark.long
def test_cold_under_load_and_once_more_with_a_second_bench_beside(tmp_path, monkeypatch) -> None:
    """No byte code, no compiled kernels, files not in memory, four busy processes."""
    cold = without_byte_code(tmp_path)
    first = bench_in(tmp_path / "first", **cold, **use(monkeypatch, next_domain()))
    forget_files()
    try:
        with busy(4):
            said = start(first)
            assert said[-1] == "8 of 8 nodes are up"
            assert any(text.startswith(f"{n} of 8") for n in range(1, 8) for text in said)
            second = bench_in(tmp_path / "second", **cold, **use(monkeypatch, next_domain()))
            try:
                assert start(second)[-1] == "8 of 8 nodes are up"
                nodes = [*first.running.values(), *second.running.values()]
                assert not first.why_ended()
            finally:
                second.stop()
    finally:
        first.stop()
    assert codes(nodes) == {0}


def test_a_node_that_dies_in_the_start_is_named_and_nothing_stays(tmp_path, monkeypatch) -> None:
    bench = bench_in(tmp_path, **use(monkeypatch, next_domain()))
    with bench, BenchClient() as client:
        nodes = list(bench.running.values())
        bench.running["encoders"].kill()
        with pytest.raises(BenchError, match=r"^encoders ended by itself \(killed by SIGKILL\)"):
            client.wait_connected(bench)
    assert all(node.poll() is not None for node in nodes)


def test_a_node_that_hangs_is_named_with_those_that_wait_for_it(tmp_path, monkeypatch) -> None:
    """With shared memory, which Fast DDS leaves behind where a node is killed."""
    environment = use(monkeypatch, next_domain()) | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    before = shared_memory()
    bench = bench_in(tmp_path, **environment)
    with bench, BenchClient() as client:
        client.wait_connected(bench)
        bench.running["simulated_plant"].send_signal(signal.SIGSTOP)
        with pytest.raises(BenchError, match=r"simulated_plant runs, but .*7 of 8 nodes are up"):
            client.wait_connected(bench, timeout=8.0)
        pids = [node.pid for node in bench.running.values()]
        bench.running["simulated_plant"].kill()
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)
    assert not shared_memory() - before


def shared_memory() -> set[str]:
    """Segments and ports of the middleware that have an owner."""
    return {lock.name for lock in SHARED_MEMORY.glob("fastrtps_*_el")}


@pytest.mark.long
@pytest.mark.timeout(3 * 3600)
def test_fifty_cold_starts_under_load(tmp_path, monkeypatch) -> None:
    count = int(os.environ.get("FLATPLANK_STARTS", "50"))
    for number in range(count):
        folder = tmp_path / str(number)
        forget_files()
        cold = without_byte_code(folder)
        with busy(8), bench_in(folder, **cold, **use(monkeypatch, next_domain())) as bench:
            with BenchClient() as client:
                client.wait_connected(bench)
            nodes = list(bench.running.values())
        assert codes(nodes) == {0}, number
        print(f"start {number + 1} of {count} is connected", flush=True)
