# SPDX-License-Identifier: Apache-2.0
"""A real graph for one test: own domain on loopback, own processes, all ended by their ids."""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_msgs.srv import Advance

FIRST_DOMAIN = 20
DOMAINS = 80
"""Domains up to 101 do not meet the ports of ordinary programs on Linux."""

_used = 0


def next_domain() -> int:
    """A domain that no other test of this process, and hardly one of another process, uses."""
    global _used
    _used += 1
    return FIRST_DOMAIN + (os.getpid() * 7 + _used) % DOMAINS


def loopback(domain: int) -> dict[str, str]:
    """Environment of a graph that nobody else hears, without shared memory that a kill leaves behind."""
    return {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    }


class Graph:
    """Processes, a client in the same domain, and the data folder."""

    def __init__(self, processes: BenchProcesses, client: BenchClient, data: Path) -> None:
        self.processes, self.client, self.data = processes, client, data

    def names(self) -> list[str]:
        return list(self.processes.running)

    def advance(self, cycles: int, timeout: float = 60.0) -> int:
        """Let the held bus make cycles; the number of the last one."""
        return self.client.call(
            Advance, "/simulated_plant/advance", timeout=timeout, cycles=cycles
        ).cycle

    def kill(self, name: str) -> None:
        """`kill -9` of one node."""
        process = self.processes.running.pop(name)
        process.kill()
        process.wait()


@contextmanager
def graph(tmp_path: Path, monkeypatch, without=frozenset(), **setup):
    """A held simulated bench whose nodes have found each other."""
    environment = loopback(next_domain())
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    data = tmp_path / "data"
    setup = {"pace": "hold", "data": str(data), **setup}
    log = tmp_path / "nodes.log"
    processes = BenchProcesses(
        BenchSetup(**setup), environment=environment, log=log, without=frozenset(without)
    )
    with processes, BenchClient() as client:
        client.wait_connected(processes.running, timeout=60.0)
        yield Graph(processes, client, data)
    assert not processes.running
