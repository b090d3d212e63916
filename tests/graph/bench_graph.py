# SPDX-License-Identifier: Apache-2.0
"""A real graph for one test: own domain on loopback, own processes, all ended by their ids."""

from __future__ import annotations

import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from domains import loopback, next_domain
from std_srvs.srv import SetBool

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_control.recording.mcap_scan import scan, stored_messages
from flatplank_control.recording.topics import at_every_cycle
from flatplank_hw.nodes.qos import STREAM
from flatplank_msgs.msg import BusInputs
from flatplank_msgs.srv import (
    Advance,
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)

KEPT = 20000
"""cycles of which the counts are kept"""

STANDING_COUNTS = 2
"""a wheel that stands rocks within its encoder's last steps; a turning one makes 60 in 50 cycles
"""


class Graph:
    """Processes, a client in the same domain, and the data folder."""

    def __init__(self, processes: BenchProcesses, client: BenchClient, data: Path) -> None:
        self.processes, self.client, self.data = processes, client, data
        self._counts: dict[int, int] = {}
        self._stamp_ns = 0
        client.node.create_subscription(BusInputs, "/bus/inputs", self._on_inputs, STREAM)

    def names(self) -> list[str]:
        return list(self.processes.nodes())

    def advance(self, cycles: int, timeout: float = 60.0) -> int:
        """Let the held bus make cycles; the number of the last one."""
        return self.client.call(
            Advance, "/simulated_plant/advance", timeout=timeout, cycles=cycles
        ).cycle

    def listen(self, kind: type, topic: str) -> list[Any]:
        """Messages from now on, in the order of their arrival."""
        seen: list[Any] = []
        self.client.node.create_subscription(kind, topic, seen.append, STREAM)
        return seen

    def message_after(self, cycles: int, seen: list[Any]) -> Any:
        """Let the held bus make cycles; the message of the last one, or of a later one.

        What was heard before may be old: this process hears nothing while it does not spin.
        """
        last = self.advance(cycles)
        while not seen or seen[-1].cycle < last:
            if not seen:
                self.advance(1)  # sent before the subscription was connected: a later one comes
            self.client.spin(1.0)
        return seen[-1]

    def call(self, kind, name, /, **fields):
        """A service that must say yes."""
        response = self.client.call(kind, name, **fields)
        assert getattr(response, "accepted", getattr(response, "success", True)), response
        return response

    def roll(self, mode: str = "slip", record: str = "") -> None:
        """Loaded tire, drive enabled, plank moving for two seconds: 5 cm after the trigger."""
        self.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=10)
        self.advance(100)
        self.call(SetValue, "/simulated_plant/load_to", value=3700.0)
        self.advance(4000)
        self.call(
            SetWaveform,
            "/slip_sequencer/set_waveform",
            name="step",
            parameters=["kappa"],
            values=[0.02],
            start_position=0.3,
            effective_rolling_radius=0.3108,
        )
        self.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode=mode)
        self.call(SetBool, "/wheel_drive/enable", data=True)
        if record:
            self.call(
                StartRecording, "/recorder/start", name=record, record="tire: TOY", at_once=True
            )
        self.call(
            PlankSwitch, "/simulated_plant/plank", direction=1, fast=True, stop_at=float("nan")
        )
        self.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=1)
        self.advance(500)

    def _on_inputs(self, msg: BusInputs) -> None:
        first = msg.cycle - msg.count + 1
        self._counts.update(enumerate(msg.wheel_counts, first))
        self._stamp_ns = msg.header.stamp.sec * 1_000_000_000 + msg.header.stamp.nanosec
        while next(iter(self._counts)) < first - KEPT:
            del self._counts[next(iter(self._counts))]

    def shaft(self, cycles: int) -> list[int]:
        """Wheel encoder counts of the next bus cycles, read from the raw image."""
        before = self.advance(0)
        last = self.advance(cycles)
        end = time.monotonic() + 30.0
        while last not in self._counts and time.monotonic() < end:
            self.client.spin(0.5)
        return [self._counts[cycle] for cycle in range(before + 1, last + 1)]

    def wheel_turns(self, cycles: int = 50) -> bool:
        """Whether the wheel moved at all in that many cycles."""
        counts = self.shaft(cycles)
        return max(counts) - min(counts) > STANDING_COUNTS

    def stop_recording(self) -> StopRecording.Response:
        return self.call(StopRecording, "/recorder/stop", status="stopped")

    def wait_written(self, bag: Path, mode: str = "slip") -> None:
        """Wait until an open bag holds what every node said of the last cycle."""
        last = self.advance(0)
        while last not in self._counts:
            self.client.spin(0.5)
        (path,) = bag.glob("*.mcap")
        while not set(at_every_cycle(mode)) <= _written_up_to(path, self._stamp_ns):
            self.client.spin(0.25)

    def kill(self, name: str) -> None:
        """`kill -9` of one node."""
        process = self.processes.running.pop(name)
        process.kill()
        process.wait()


def _written_up_to(path: Path, stamp_ns: int) -> set[str]:
    """Topics of a bag that is still open which have a message of that bench time, or a later."""
    index = scan(path).index
    stored = stored_messages(path, index)
    return {index.channels[m.channel].topic for m in stored if m.stamp_ns >= stamp_ns}


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
        bench = Graph(processes, client, data)
        client.wait_connected(processes)
        yield bench
    assert not processes.running


def shared_graph(**setup):
    """A fixture with one graph for all tests of a module, none of which ends a node."""

    @pytest.fixture(scope="module")
    def bench(tmp_path_factory):
        folder = tmp_path_factory.mktemp("shared")
        with (
            pytest.MonkeyPatch.context() as monkeypatch,
            graph(folder, monkeypatch, **setup) as one,
        ):
            yield one

    return bench
