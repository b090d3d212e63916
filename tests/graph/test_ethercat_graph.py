# SPDX-License-Identifier: Apache-2.0
"""The whole graph on real EtherCAT frames: the same measurement as on the simulated plant."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from domains import loopback, next_domain
from emulated_graph import EmulatedGraph, emulated_graph, table_of
from std_srvs.srv import SetBool, Trigger

from flatplank_control.bench.setup import BenchSetup
from flatplank_hw.bus.image import Digital
from flatplank_hw.cia402 import State
from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState
from flatplank_msgs.srv import SdoRead, SdoWrite, SetOperationMode, SetSlipStep, SetValue
from flatplank_sim.twin.twin import Cycle, Twin

pytestmark = pytest.mark.graph

FZ = 1000.0
KAPPA, RADIUS = 0.05, 0.3108
ROLL, STEP_AHEAD, SLIP = 0.04, 0.01, 0.05
"""plank travel [m]: free rolling; to the slip step; of the slip run"""
ENABLED, FAULT = State.OPERATION_ENABLED, State.FAULT
RECORDS = {
    "rolled": {"fz": FZ, "measurement": "free_rolling"},
    "slipped": {
        "fz": FZ,
        "measurement": "slip",
        "kappa": KAPPA,
        "effective_rolling_radius": RADIUS,
    },
}
SEEDS = range(2, 10)
PIECE = 0.01
"""[m]"""
SIGMAS = 6.0
"""spreads of eight runs: beyond it by chance once in some hundred tests"""
RESOLUTION = 0.03
"""one step of the wheel's encoder over a piece [rad/m]; of forces hardly anything [N]"""


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[EmulatedGraph]:
    with emulated_graph(tmp_path, monkeypatch) as graph:
        yield graph


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
        assert twin.drive.set_operation_mode(mode, 0.0).accepted
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
    table = table_of(bag)
    return np.column_stack([table[k] for k in ("plank_position", "wheel_angle", "fx")])


def in_pieces(rolled: np.ndarray, slipped: np.ndarray) -> np.ndarray:
    """Means over 10 mm of plank travel: Fx of free rolling, how much Fx rises by the slip step,
    and the turn of the wheel [rad/m] in both. How the plank stops in between is left to chance;
    a mean over travel, because so is how long it stands between recorder on and plank forward."""

    def means(rows: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
        edges = rows[0, 0] + PIECE * np.arange(count + 1)
        inside = [(rows[:, 0] >= a) & (rows[:, 0] < b) for a, b in pairwise(edges)]
        turns = [np.ptp(rows[i, 1]) / np.ptp(rows[i, 0]) for i in inside]
        forces = [np.trapezoid(rows[i, 2], rows[i, 0]) / np.ptp(rows[i, 0]) for i in inside]
        return np.array(forces), np.array(turns)

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


def test_the_bench_measures_on_ethercat_as_on_the_simulated_plant(
    bench: EmulatedGraph, tmp_path: Path
) -> None:
    bench.ask(SetValue, "/simulated_plant/load_to", value=FZ)
    bench.until(HubState, lambda s: abs(s.fz_filtered - FZ) < 0.02 * FZ, 30.0)
    rolled = bench.record("rolled", RECORDS["rolled"], ROLL, lambda: free_rolling(bench))
    slipped = bench.record("slipped", RECORDS["slipped"], SLIP, lambda: slip_step(bench))
    sdo(bench)
    emergency_stop(bench)
    diagnostics = bench.until(
        DiagnosticArray, lambda d: of_the_bus(d).level == DiagnosticStatus.OK, 30.0
    )
    status = of_the_bus(diagnostics)
    values = {pair.key: pair.value for pair in status.values}
    assert values["health"] == "OK", status
    assert int(values["sent"]) == int(values["received"]) + int(values["lost"])
    plants = np.array([in_pieces(*on_the_plant(seed)) for seed in SEEDS])
    assert_same(in_pieces(rows_of(rolled), rows_of(slipped)), plants)


def of_the_bus(message: DiagnosticArray) -> DiagnosticStatus:
    (status,) = [s for s in message.status if s.name == "/ethercat_bus"]
    return status


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
