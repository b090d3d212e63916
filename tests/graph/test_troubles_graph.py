# SPDX-License-Identifier: Apache-2.0
"""Who has a terminal and no source code learns from /diagnostics what is wrong: ten troubles."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from bench_graph import Graph, graph
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosbags.highlevel import AnyReader
from std_srvs.srv import SetBool, Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_control.recording.mcap_scan import scan, stored_messages
from flatplank_control.recording.typestore import typestore
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.troubles import TROUBLES
from flatplank_msgs.msg import DriveStatus
from flatplank_msgs.srv import (
    Claim,
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetSlipStep,
    SetValue,
    StartRecording,
)

pytestmark = pytest.mark.graph
SHORT = {"kappa": 0.02, "step_position": 0.02, "end_position": 0.04}
SATURATION = 1.5
"""[V]"""
TIMEOUT_S = 15.0
"""[s of wall clock]; a status comes every second"""


class Listener:
    """What a terminal beside the bench sees: `/diagnostics` and the log of the nodes."""

    def __init__(self, bench: Graph, log: Path) -> None:
        self.bench, self.log = bench, log
        self.message: DiagnosticArray | None = None
        self.status: DriveStatus | None = None
        node = bench.client.node
        node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, 10)
        node.create_subscription(DriveStatus, "/wheel_drive/status", self._see, STREAM)

    def _hear(self, message: DiagnosticArray) -> None:
        self.message = message

    def _see(self, message: DriveStatus) -> None:
        self.status = message

    def until(self, true: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + TIMEOUT_S
        while not true():
            assert time.monotonic() < end, (what, self.message)
            self.bench.client.spin(0.2)

    def named(self, trouble: str) -> DiagnosticStatus | None:
        for status in self.message.status if self.message else ():
            values = {pair.key: pair.value for pair in status.values}
            if trouble in values.get("troubles", "").split(", "):
                return status
        return None

    def hears(self, trouble: str, detail: str = "") -> DiagnosticStatus:
        """The trouble is in one message of /diagnostics, with its level and what to do, and was
        logged once."""
        self.until(lambda: self.named(trouble) is not None, trouble)
        status, known = self.named(trouble), TROUBLES[trouble]
        assert status.level >= bytes([known.level])
        assert known.text in status.message and known.remedy in status.message
        assert detail in status.message
        said = [line for line in self.lines() if known.text in line and "over:" not in line]
        assert any(detail in line and known.remedy in line for line in said), (trouble, said)
        return status

    def gone(self, trouble: str) -> None:
        self.until(lambda: self.named(trouble) is None, f"{trouble} is over")

    def lines(self) -> list[str]:
        return self.log.read_text(encoding="utf-8", errors="replace").splitlines()


def plank(bench: Graph, direction: int) -> None:
    bench.call(PlankSwitch, "/simulated_plant/plank", direction=direction, fast=True,
               stop_at=float("nan"))  # fmt: skip


def enable(bench: Graph) -> None:
    bench.call(SetBool, "/wheel_drive/enable", data=True)
    bench.advance(25)


WRONG = {"measurement_hub": {"saturation_volts": SATURATION}, "encoders": {"gear_ratio": 1200.0}}
"""a hub whose amplifier is too sensitive for the load, a gear that the machine has not"""


def test_troubles_are_in_diagnostics_in_the_log_and_in_the_bag(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, parameters=WRONG, separate=("slip_sequencer",)) as bench:
        seen = Listener(bench, tmp_path / "nodes.log")
        bench.advance(10)
        names = {f"/{name}" for name in bench.names()}
        seen.until(
            lambda: seen.message is not None and {s.name for s in seen.message.status} >= names,
            "one message has every node",
        )
        assert all(s.level == DiagnosticStatus.OK for s in seen.message.status), seen.message
        bench.roll(record="troubles")
        bench.advance(250)
        seen.hears("saturated", "C")
        seen.hears("cross_check", "limit 0.02 rad")

        answer = bench.client.call(
            SetSlipStep, "/slip_sequencer/set_slip_step", kappa=0.7,
            start_position=1.0, effective_rolling_radius=0.31,
        )  # fmt: skip
        assert not answer.accepted
        seen.hears("refused", f"/slip_sequencer/set_slip_step: {answer.reason}")

        bench.call(Trigger, "/wheel_drive/quick_stop")
        bench.advance(50)
        seen.hears("quick_stop")
        status = seen.hears("drag", "plank at")
        assert status.name == "/wheel_drive" and status.level == DiagnosticStatus.ERROR
        seen.until(lambda: seen.status.stop_reason == DriveStatus.STOP_QUICK_STOP, "the status")
        assert seen.status.stop_text == TROUBLES["quick_stop"].text
        plank(bench, 0)
        bench.advance(50)
        seen.gone("drag")
        enable(bench)
        seen.gone("quick_stop")

        bench.call(SetBool, "/simulated_plant/emergency_stop", data=True)
        bench.advance(25)
        seen.hears("emergency_stop")
        bench.call(SetBool, "/simulated_plant/emergency_stop", data=False)
        bench.advance(25)

        bench.call(Claim, "/operator/claim", client="somebody")
        enable(bench)
        bench.advance(250)
        seen.hears("heartbeat", "for 5")

        bench.call(Trigger, "/simulated_plant/unload")
        bench.advance(2000)
        bench.call(Trigger, "/measurement_hub/tare")
        enable(bench)
        plank(bench, 1)
        bench.advance(250)
        plank(bench, 0)
        bench.advance(50)
        seen.hears("plank_stopped", "plank at")
        seen.hears("tare_given_up", "the plank moved")

        bench.call(SetBool, "/simulated_plant/emergency_stop", data=True)
        bench.advance(25)
        with pytest.raises(BenchError):
            bench.client.measure(SHORT, simulated=True)
        seen.hears("measurement_stopped")
        bench.call(SetBool, "/simulated_plant/emergency_stop", data=False)
        bench.advance(25)
        bag = Path(bench.processes.setup.data) / "troubles"

        bench.call(SetValue, "/simulated_plant/load_to", value=3700.0)
        bench.advance(2000)
        bench.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=1)
        bench.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
        enable(bench)
        plank(bench, 1)
        bench.advance(100)
        bench.kill("slip_sequencer")
        bench.advance(50)
        seen.hears("reference", "ms old")
        plank(bench, 0)
        seen.hears("node_silent", "(/slip_sequencer)")
        (silent,) = [s for s in seen.message.status if s.name == "/slip_sequencer"]
        assert silent.level == DiagnosticStatus.STALE
    told = in_the_bag(bag)
    for name in ("saturated", "cross_check", "quick_stop", "drag", "emergency_stop", "heartbeat"):
        assert any(TROUBLES[name].text in text for text in told["/diagnostics"]), name
    stops = {"quick_stop", "emergency_stop", "heartbeat", "plank_stopped"}
    assert {TROUBLES[name].text for name in stops} <= told["/wheel_drive/status"]


def in_the_bag(bag: Path) -> dict[str, set[str]]:
    """Texts that were recorded, by topic."""
    told: dict[str, set[str]] = {"/diagnostics": set(), "/wheel_drive/status": set()}
    with AnyReader([bag], default_typestore=typestore()) as reader:
        for connection, _, raw in reader.messages():
            if connection.topic in told:
                message = reader.deserialize(raw, connection.msgtype)
                texts = (
                    [message.stop_text]
                    if connection.topic == "/wheel_drive/status"
                    else [status.message for status in message.status]
                )
                told[connection.topic].update(texts)
    return told


@pytest.mark.parametrize("separate", [(), ("recorder",)], ids=["one process", "apart"])
def test_the_log_of_a_stop_is_in_the_bag(separate, tmp_path, monkeypatch):
    """Also that of the nodes which share the recorder's process."""
    text = TROUBLES["quick_stop"].text
    with graph(tmp_path, monkeypatch, separate=separate) as bench:
        bench.advance(10)
        named = {"name": "logged", "record": "tire: TOY", "at_once": True}
        bench.call(StartRecording, "/recorder/start", **named)
        bench.call(Trigger, "/wheel_drive/quick_stop")
        bench.advance(10)
        bag = bench.data / "logged"
        listener = Listener(bench, tmp_path / "nodes.log")
        listener.until(lambda: text in str(logged(bag)), f"{text} in the bag")
        bench.stop_recording()


def logged(bag: Path) -> list[bytes]:
    """Messages of the log that are on disk, serialised."""
    (file,) = bag.glob("*.mcap")
    index = scan(file).index
    (channel,) = (c.id for c in index.channels.values() if c.topic == "/rosout")
    return [m.data for m in stored_messages(file, index) if m.channel == channel]


def test_a_bag_has_the_troubles_of_each_second_of_bench_time(tmp_path, monkeypatch):
    """However fast the bench time runs."""
    seconds, per_second = 5, 250
    with graph(tmp_path, monkeypatch) as bench:
        bench.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=1)
        bench.call(
            StartRecording, "/recorder/start", name="brief", record="tire: TOY", at_once=True
        )
        bench.advance(seconds * per_second)
        bench.stop_recording()
    with AnyReader([bench.data / "brief"], default_typestore=typestore()) as reader:
        of_topic = [c for c in reader.connections if c.topic == "/diagnostics"]
        stamps = [
            reader.deserialize(raw, c.msgtype).header.stamp
            for c, _, raw in reader.messages(connections=of_topic)
        ]
    found = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
    gaps = [after - before for before, after in pairwise(found)]
    assert len(found) >= seconds and max(gaps) <= 1.0 + 1.0 / per_second
