# SPDX-License-Identifier: Apache-2.0
"""The whole graph on real EtherCAT frames: the same measurement as on the simulated plant."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from bench_graph import loopback, next_domain
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import SetBool, Trigger

from flatplank_analysis.data import Campaign, MeasurementTable
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.twin import Cycle, Twin
from flatplank_control.nodes.client import BenchClient
from flatplank_hw.bus.image import Digital
from flatplank_hw.drive.cia402 import State
from flatplank_hw.ethercat.namespace import BenchNamespace, NamespaceError
from flatplank_hw.nodes.qos import STREAM
from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState
from flatplank_msgs.srv import (
    PlankSwitch,
    SdoRead,
    SdoWrite,
    SetOperationMode,
    SetSlipStep,
    SetValue,
    StartRecording,
    StopRecording,
)

pytestmark = [pytest.mark.graph, pytest.mark.timeout(240)]

FZ = 1000.0
KAPPA, RADIUS = 0.05, 0.3108
ROLL, STEP_AHEAD, SLIP = 0.04, 0.01, 0.05
"""plank travel [m]: free rolling; to the slip step; of the slip run"""
ENABLED, FAULT = State.OPERATION_ENABLED, State.FAULT
BUS_LOST = 1
"""stop reason"""
RECORDS = {
    "rolled": {"measurement": "free_rolling"},
    "slipped": {"measurement": "slip", "kappa": KAPPA, "effective_rolling_radius": RADIUS},
}
SEEDS = range(2, 10)
PIECE = 0.01
"""[m]"""
SIGMAS = 6.0
"""spreads of eight runs: beyond it by chance once in some hundred tests"""
RESOLUTION = 0.03
"""one step of the wheel's encoder over a piece [rad/m]; of forces hardly anything [N]"""


class EmulatedGraph:
    """The nodes, a client, and the latest samples."""

    def __init__(self, client: BenchClient, nodes: BenchProcesses) -> None:
        self.client = client
        self.nodes = nodes
        self.latest: dict[type, object] = {}
        for kind, topic in {
            BusInputs: "/bus/inputs",
            EncoderState: "/encoders/state",
            HubState: "/measurement_hub/state",
            DriveStatus: "/wheel_drive/status",
            DiagnosticArray: "/diagnostics",
        }.items():
            client.node.create_subscription(
                kind, topic, lambda message, kind=kind: self.latest.update({kind: message}), STREAM
            )

    def until(self, kind: type, condition: Callable[[object], bool], seconds: float) -> object:
        """The first sample that fulfils a condition; bench time, which the emulated bus keeps."""
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

    def ask(self, kind: type, name: str, /, **fields) -> object:
        """A service that must say yes."""
        answer = self.client.call(kind, name, timeout=20.0, **fields)
        assert getattr(answer, "accepted", getattr(answer, "success", True)), (name, answer)
        return answer

    def record(self, name: str, distance: float, prepare: Callable[[], None]) -> str:
        """One run: drive on, recorder on, plank forward and at rest again; its bag."""
        start = self.until(EncoderState, lambda _: True, 1.0).plank_position
        prepare()
        self.ask(SetBool, "/wheel_drive/enable", data=True)
        self.until(DriveStatus, lambda s: s.state == ENABLED, 2.0)
        self.ask(
            StartRecording,
            "/recorder/start",
            name=name,
            record=yaml.safe_dump({"tire": "TOY", "fz": FZ, **RECORDS[name]}),
            at_once=True,
        )
        self.plank(1)
        self.until(EncoderState, lambda s: s.plank_position > start + distance, 10.0)
        self.plank(0)
        self.until(EncoderState, lambda s: not s.plank_moving, 5.0)
        bag = self.ask(StopRecording, "/recorder/stop", status="complete").path
        self.ask(SetBool, "/wheel_drive/enable", data=False)
        self.until(DriveStatus, lambda s: s.state != ENABLED, 2.0)
        return bag

    def plank(self, direction: int) -> None:
        self.ask(
            PlankSwitch,
            "/simulated_plant/plank",
            direction=direction,
            fast=True,
            stop_at=math.nan,
        )


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[EmulatedGraph]:
    """A running emulated bench in a domain of its own."""
    try:
        BenchNamespace().close()
    except NamespaceError as error:
        pytest.skip(str(error))
    environment = loopback(next_domain())
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    setup = BenchSetup(kind="emulated", data=str(tmp_path / "data"))
    nodes = BenchProcesses(setup, environment=environment, log=tmp_path / "nodes.log")
    with nodes, BenchClient() as client:
        client.wait_connected(nodes.running, timeout=90.0)
        yield EmulatedGraph(client, nodes)
    assert not nodes.running


def free_rolling(graph: EmulatedGraph) -> None:
    graph.ask(SetOperationMode, "/wheel_drive/set_operation_mode", mode="free_rolling", value=0.0)


def slip_step(graph: EmulatedGraph) -> None:
    at = graph.until(EncoderState, lambda _: True, 1.0).plank_position + STEP_AHEAD
    graph.ask(
        SetSlipStep,
        "/slip_sequencer/set_slip_step",
        kappa=KAPPA,
        start_position=at,
        effective_rolling_radius=RADIUS,
    )
    graph.ask(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip", value=0.0)


class PlantRuns:
    """The same two runs on the simulated plant alone, with other noise."""

    def __init__(self, seed: int) -> None:
        self.twin = Twin(BenchSetup(seed=seed))
        self.now = self.twin.cycle()

    def until(self, condition: Callable[[Cycle], bool], seconds: float) -> list[Cycle]:
        cycles = []
        for _ in range(round(seconds * 250)):
            self.now = self.twin.cycle()
            cycles.append(self.now)
            if condition(self.now):
                return cycles
        raise AssertionError(f"not reached: {self.now}")

    def run(self, mode: str, distance: float) -> np.ndarray:
        """Rows of plank position, wheel angle, Fx, from the motion trigger on."""
        start = self.now.encoders.plank_position
        twin, operator = self.twin, self.twin.plant.operator
        assert twin.set_mode(mode, 0.0).accepted
        assert twin.drive.enable().accepted
        self.until(lambda c: c.drive.state == ENABLED, 2.0)
        operator.plank(1, fast=True)
        cycles = self.until(lambda c: c.encoders.plank_position > start + distance, 10.0)
        operator.plank(0, fast=True)
        cycles += self.until(lambda c: not c.encoders.plank_moving, 5.0)
        twin.drive.disable()
        self.until(lambda c: c.drive.state != ENABLED, 2.0)
        rows = np.array(
            [(c.encoders.plank_position, c.encoders.wheel_angle, c.hub.contact.fx) for c in cycles]
        )
        (zeroed,) = np.nonzero(np.diff(rows[:, 0]) < -1e-3)
        return rows[zeroed[-1] + 1 :] if zeroed.size else rows


def on_the_plant(seed: int) -> list[np.ndarray]:
    runs = PlantRuns(seed)
    runs.twin.plant.operator.load_to(FZ)
    runs.until(lambda c: abs(c.hub.fz_filtered - FZ) < 0.02 * FZ, 30.0)
    rolled = runs.run("free_rolling", ROLL)
    at = runs.now.encoders.plank_position + STEP_AHEAD
    assert runs.twin.sequencer.set_slip_step(KAPPA, at, RADIUS).accepted
    return [rolled, runs.run("slip", SLIP)]


def rows_of(bag: str) -> np.ndarray:
    """What the analysis reads from the bag: plank, wheel angle, Fx."""
    campaign = Campaign.load(bag)
    assert not campaign.problems, campaign.problems
    table: MeasurementTable = campaign.runs[0].table()
    record = yaml.safe_load((Path(bag) / "run.yaml").read_text(encoding="utf-8"))
    assert (record["status"], record["cycles_lost"]) == ("complete", 0), record
    return np.column_stack([table[k] for k in ("plank_position", "wheel_angle", "fx")])


def in_pieces(rolled: np.ndarray, slipped: np.ndarray) -> np.ndarray:
    """Means over 10 mm of plank travel: Fx of free rolling, how much Fx rises by the slip step,
    and the turn of the wheel [rad/m] in both. How the plank stops in between is left to chance."""

    def means(rows: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        edges = rows[0, 0] + PIECE * np.arange(count + 1)
        inside = [(rows[:, 0] >= a) & (rows[:, 0] < b) for a, b in pairwise(edges)]
        turns = [np.ptp(rows[i, 1]) / np.ptp(rows[i, 0]) for i in inside]
        return np.array([rows[i, 2].mean() for i in inside]), np.array(turns)

    (force, turn), (slip_force, slip_turn) = means(rolled, 3), means(slipped, 4)
    return np.concatenate([force, slip_force[1:] - slip_force[0], turn, slip_turn[1:]])


def assert_same(bus: np.ndarray, plants: np.ndarray) -> None:
    """The bus's run is one more of the plant's, which differ by their noise."""
    mean, spread = plants.mean(axis=0), plants.std(axis=0, ddof=1)
    text = f"bus {bus.round(2)}\nplant {mean.round(2)}\nspread {spread.round(2)}"
    print(text)
    assert np.all(np.abs(bus - mean) < SIGMAS * spread + RESOLUTION), text


def sdo(graph: EmulatedGraph) -> None:
    """Objects of the drive, read and written while the bus runs."""
    drive = {"slave": "wheel_drive", "index": 0x6085, "subindex": 0}
    name = "/ethercat_bus/sdo_read"
    data = bytes(graph.ask(SdoRead, name, **drive).data)
    other = bytes([data[0] ^ 1]) + data[1:]
    graph.ask(SdoWrite, "/ethercat_bus/sdo_write", **drive, data=other)
    assert bytes(graph.ask(SdoRead, name, **drive).data) == other
    for bad, word in (({"slave": "wheel_driv"}, "wheel_drive"), ({"index": 0x5FFF}, "exist")):
        refused = graph.client.call(SdoRead, name, **{**drive, **bad})
        assert not refused.accepted and word in refused.reason, refused


def emergency_stop(graph: EmulatedGraph) -> None:
    """A real stop stays until an explicit reset, also when its cause is gone."""

    def reached(state: int) -> None:
        graph.until(DriveStatus, lambda s: s.state == state, 2.0)

    enable, stop = "/wheel_drive/enable", "/simulated_plant/emergency_stop"
    graph.ask(SetBool, enable, data=True)
    reached(ENABLED)
    graph.ask(SetBool, stop, data=True)
    reached(FAULT)
    graph.ask(SetBool, stop, data=False)
    graph.until(BusInputs, lambda i: bool(i.digital[-1] & Digital.EMERGENCY_STOP_OK), 2.0)
    refused = graph.client.call(SetBool, enable, data=True)
    assert not refused.success and "reset" in refused.message, refused
    graph.ask(Trigger, "/wheel_drive/reset_fault")
    graph.until(DriveStatus, lambda s: s.state < ENABLED, 2.0)
    graph.ask(SetBool, enable, data=True)
    reached(ENABLED)


def bus_process_killed(graph: EmulatedGraph) -> None:
    """An enabled drive is told, and the node ends, since no bus comes back by itself."""
    node = graph.nodes.running["ethercat_bus"]
    (master,) = (pid for pid, words in below(node.pid) if "flatplank_hw.ethercat.master" in words)
    os.kill(master, signal.SIGKILL)
    graph.until(DriveStatus, lambda s: s.stop_reason == BUS_LOST, 2.0)
    assert node.wait(30.0) == 1
    assert "the bus process has ended" in graph.nodes.log.read_text()


def below(pid: int) -> Iterator[tuple[int, list[str]]]:
    """Processes that a process has started, with their command lines."""
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        words = Path(f"/proc/{child}/cmdline").read_text().split("\0")
        yield int(child), words
        yield from below(int(child))


def test_the_bench_measures_on_ethercat_as_on_the_simulated_plant(
    bench: EmulatedGraph, tmp_path: Path
) -> None:
    bench.ask(SetValue, "/simulated_plant/load_to", value=FZ)
    bench.until(HubState, lambda s: abs(s.fz_filtered - FZ) < 0.02 * FZ, 30.0)
    rolled = bench.record("rolled", ROLL, lambda: free_rolling(bench))
    slipped = bench.record("slipped", SLIP, lambda: slip_step(bench))
    sdo(bench)
    emergency_stop(bench)
    diagnostics = bench.until(DiagnosticArray, lambda _: True, 5.0)
    (status,) = diagnostics.status
    values = {pair.key: pair.value for pair in status.values}
    assert status.level == DiagnosticStatus.OK and values["health"] == "OK", status
    assert int(values["sent"]) == int(values["received"]) + int(values["lost"])
    bus_process_killed(bench)
    plants = np.array([in_pieces(*on_the_plant(seed)) for seed in SEEDS])
    assert_same(in_pieces(rows_of(rolled), rows_of(slipped)), plants)


REFUSED = {
    "no interface given": ({"interface": ""}, "ip link"),
    "no such interface": ({"interface": "fpnone0"}, "is not there; found"),
    "name over 15 characters": ({"interface": "enp0s31f6-bench-1"}, "at most 15 characters"),
    "no slaves": ({"interface": "lo"}, "slave"),
    "no such bus file": ({"interface": "lo", "bus_file": "benhc"}, "benhc"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_bus_that_cannot_be_ends_the_node_with_one_line(case: str, tmp_path: Path) -> None:
    parameters, reason = REFUSED[case]
    file = tmp_path / "bus.yaml"
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}), encoding="utf-8")
    words = [sys.executable, "-m", "flatplank_hw.nodes.ethercat_bus", "--ros-args"]
    done = subprocess.run(
        [*words, "--params-file", str(file)],
        env={**os.environ, **loopback(next_domain())},
        capture_output=True,
        text=True,
        timeout=60,
    )
    lines = [line for line in done.stderr.splitlines() if "not configured" in line]
    assert (done.returncode, len(lines)) == (1, 1), done.stderr
    assert reason in lines[0]
    assert "Traceback" not in done.stderr
