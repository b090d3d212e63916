# SPDX-License-Identifier: Apache-2.0
"""A graph on real EtherCAT frames for tests: its client, and the processes behind its bus."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import yaml
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from domains import loopback, next_domain
from ethercat_rig import namespace
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import SetBool

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_data.campaign import Campaign
from flatplank_data.table import MeasurementTable
from flatplank_hw.cia402 import State
from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState, SequencerState
from flatplank_msgs.srv import PlankSwitch, StartRecording, StopRecording

LATEST = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=1
)
"""A client that is slower than the bench hears the newest sample all the same."""
TOPICS = {
    BusInputs: "/bus/inputs",
    EncoderState: "/encoders/state",
    HubState: "/measurement_hub/state",
    DriveStatus: "/wheel_drive/status",
    SequencerState: "/slip_sequencer/state",
    DiagnosticArray: "/diagnostics",
}


def below(pid: int) -> Iterator[tuple[int, list[str]]]:
    """Processes that a process has started, with their command lines."""
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        words = Path(f"/proc/{child}/cmdline").read_text().split("\0")
        yield int(child), words
        yield from below(int(child))


class EmulatedGraph:
    """The nodes, a client, and the latest samples."""

    def __init__(self, client: BenchClient, nodes: BenchProcesses) -> None:
        self.client = client
        self.nodes = nodes
        self.latest: dict[type, object] = {}
        self.newest = Time()
        for kind, topic in TOPICS.items():
            client.node.create_subscription(kind, topic, self._keep, LATEST)

    def _keep(self, message: object) -> None:
        self.latest[type(message)] = message
        if isinstance(message, BusInputs):
            self.newest = message.header.stamp

    def catch_up(self) -> None:
        """Take what has come while nobody listened: at most one sample of each topic, and as many
        calls of a round that was begun before."""
        for _ in range(2 * len(TOPICS)):
            self.client.spin(0.0)

    def until(self, kind: type, condition: Callable[[object], bool], seconds: float) -> object:
        """The first sample from now on that fulfils a condition; bench time, which the emulated
        bus keeps."""
        self.catch_up()
        self.latest.pop(kind, None)
        start = None
        while True:
            self.client.spin(1.0)
            message = self.latest.pop(kind, None)
            if message is None:
                continue
            if condition(message):
                return message
            now = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
            start = now if start is None else start
            assert now - start < seconds, message

    def is_at_present(self, kind: type) -> None:
        """A node that was started again has made up for what it missed."""
        now = self.now()
        wanted = (now.sec, now.nanosec)
        self.until(kind, lambda s: (s.header.stamp.sec, s.header.stamp.nanosec) >= wanted, 20.0)

    def last_word(self, kind: type, condition: Callable[[object], bool]) -> None:
        """The newest sample fulfils a condition: of a node whose bus has gone, and that therefore
        may have spoken for the last time."""
        end = time.monotonic() + 30.0
        while not (kind in self.latest and condition(self.latest[kind])):
            assert time.monotonic() < end, self.latest.get(kind)
            self.client.spin(0.2)

    def ask(self, kind: type, name: str, /, **fields) -> object:
        """A service that must say yes."""
        answer = self.client.call(kind, name, timeout=20.0, **fields)
        assert getattr(answer, "accepted", getattr(answer, "success", True)), (name, answer)
        return answer

    def enable(self, on: bool = True) -> None:
        self.ask(SetBool, "/wheel_drive/enable", data=on)
        enabled = State.OPERATION_ENABLED
        self.until(DriveStatus, lambda s: (s.state == enabled) is on, 2.0)

    def now(self) -> Time:
        """Stamp of the newest sample of the bus; also of one that does not speak any more."""
        self.catch_up()
        return self.newest

    def start_recording(self, name: str, record: dict) -> None:
        self.ask(
            StartRecording,
            "/recorder/start",
            name=name,
            record=yaml.safe_dump({"tire": "TOY", **record}),
            at_once=True,
            after=self.now(),
        )

    def stop_recording(self) -> str:
        """The closed bag."""
        stop = {"status": "complete", "up_to": self.now()}
        return self.ask(StopRecording, "/recorder/stop", **stop).path

    def record(self, name: str, record: dict, distance: float, prepare: Callable[[], None]) -> str:
        """One run: drive on, recorder on, plank forward and at rest again; its bag."""
        start = self.until(EncoderState, lambda _: True, 1.0).plank_position
        prepare()
        self.enable()
        self.start_recording(name, record)
        self.plank(1)
        self.until(EncoderState, lambda s: s.plank_position > start + distance, 10.0)
        self.plank(0)
        self.until(EncoderState, lambda s: not s.plank_moving, 5.0)
        bag = self.stop_recording()
        self.enable(False)
        return bag

    def plank(self, direction: int) -> None:
        self.ask(
            PlankSwitch, "/simulated_plant/plank", direction=direction, fast=True, stop_at=math.nan
        )

    def process(self, word: str) -> tuple[int, list[str]]:
        """The process behind the bus that has a word in its command line, and that line."""
        node = self.nodes.running["ethercat_bus"]
        (found,) = (
            (pid, words)
            for pid, words in below(node.pid)
            if word in words and Path(words[0]).name.startswith("python")
        )
        return found


@contextmanager
def emulated_graph(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, separate: tuple[str, ...] = ()
) -> Iterator[EmulatedGraph]:
    """A running emulated bench in a domain of its own, or a skipped test that says why."""
    namespace().close()
    environment = loopback(next_domain())
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    setup = BenchSetup(kind="emulated", data=str(tmp_path / "data"), separate=separate)
    nodes = BenchProcesses(setup, environment=environment, log=tmp_path / "nodes.log")
    with nodes, BenchClient() as client:
        client.wait_connected(nodes)
        yield EmulatedGraph(client, nodes)
    assert not nodes.running


def table_of(bag: str, status: str = "complete") -> MeasurementTable:
    """What the analysis reads from a closed bag of this status, without a lost cycle."""
    campaign = Campaign.load(bag)
    assert not campaign.problems, campaign.problems
    record = yaml.safe_load((Path(bag) / "run.yaml").read_text(encoding="utf-8"))
    assert (record["status"], record["cycles_lost"]) == (status, 0), record
    return campaign.runs[0].table(check=False)
