# SPDX-License-Identifier: Apache-2.0
"""The faults of the EtherCAT bus under the whole graph: the same contract as without ROS, and the
bag of the run is closed and readable."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import pytest
from emulated_graph import EmulatedGraph, emulated_graph, table_of
from ethercat_contract import AFTER, WITHIN_MS, check_shaft
from ethercat_scenarios import SCENARIOS, Scenario
from stalls import GraphStalls, LongestWait, undisturbed
from std_srvs.srv import SetBool, Trigger

from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES
from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState, SequencerState
from flatplank_msgs.srv import Claim, SetOperationMode, SetWaveform, StopRecording
from flatplank_sim.emulator.control import Control

pytestmark = pytest.mark.graph

SPEED = 0.1
"""of the wheel in the air [rad/s]"""
EVERY_DAY = {
    "eight frames lost",
    "cable cut behind encoders_b",
    "drive restarts",
    "drive trips: overcurrent",
}
"""the others take minutes together"""
OTHERWISE = {"answers later than a cycle": {"ms": 20.0}}
"""an answer on the emulated bus of a graph may be 12 ms late: it shares the computer with nodes"""
HEARTBEAT_S = 0.5
PERIOD_NS = 4_000_000
ATTEMPTS = 5
STEP_AHEAD = 0.1
"""[m]"""
FASTEST_SLIP = 0.5
"""a wheel that turns faster stops later"""
SHORT, LONGER = 25, 250
"""cycles of a next measurement, and of one before a process is killed"""


class FaultyGraph:
    """A graph with the wheel in the air, and the control socket of its emulator."""

    def __init__(self, graph: EmulatedGraph, waits: LongestWait) -> None:
        self.graph, self.waits = graph, waits
        self._numbers = count()
        self.control: Control | None = None
        self.find_emulator()

    def find_emulator(self) -> None:
        """And lift the wheel off the road."""
        self.hang_up()
        _, words = self.graph.process("flatplank_sim.emulator")
        self.control = Control(words[words.index("--control") + 1])
        self.graph.ask(Trigger, "/simulated_plant/unload")
        self.graph.until(HubState, lambda s: s.loaded_radius > 0.325, 20.0)

    def hang_up(self) -> None:
        if self.control is not None:
            self.control.close()

    def cycles(self, number: int) -> None:
        """By the time of the emulator."""
        end = self.control.send("motion")["now_ns"] + number * PERIOD_NS
        while self.control.send("motion")["now_ns"] < end:
            self.graph.client.spin(0.01)

    def everybody_speaks(self) -> None:
        """Samples of everybody come again; the graph itself goes on counting who was killed for
        some seconds."""
        self.graph.client.wait_connected(self.graph.nodes)
        for kind in (EncoderState, HubState, DriveStatus):
            self.graph.until(kind, lambda _: True, 1.0)
        self.cycles(AFTER)

    def ready(self) -> None:
        """Whatever the test before has left: well, reset, at rest, nothing recorded."""
        self.control.send("mend")
        self.graph.until(BusInputs, lambda i: i.health == 0, 10.0)
        call = self.graph.client.call
        call(StopRecording, "/recorder/stop", status="stopped")
        call(SetBool, "/wheel_drive/enable", data=False)
        call(Trigger, "/wheel_drive/reset_fault")
        self.graph.until(DriveStatus, lambda s: s.state < State.SWITCHED_ON, 3.0)

    def turn(self) -> None:
        """A measurement is under way: the wheel turns and the recorder runs."""
        graph = self.graph
        service = "/wheel_drive/set_operation_mode"
        graph.ask(SetOperationMode, service, mode="velocity", value=SPEED)
        graph.enable()
        graph.until(DriveStatus, lambda s: s.velocity > 0.9 * SPEED, 2.0)
        graph.start_recording(f"fault_{next(self._numbers)}", {"measurement": "unloaded_turn"})

    def stop(self) -> None:
        self.graph.enable(False)
        self.graph.until(DriveStatus, lambda s: abs(s.velocity) < 0.01 * SPEED, 2.0)

    def readable(self, cycles: int, status: str = "complete") -> None:
        """The bag is closed and has at least so many cycles."""
        assert len(table_of(self.graph.stop_recording(), status)["time"]) >= cycles

    def shaft(self) -> dict[str, Any]:
        return self.control.send("motion")["axes"]["wheel"]

    def well(self) -> None:
        """Mended; and for a while nothing happens by itself."""
        self.control.send("mend")
        self.graph.until(BusInputs, lambda i: i.health == 0, 10.0)
        self.cycles(AFTER)

    def reset(self) -> None:
        """The drive's node may hear later than we that the bus is well."""
        for _ in range(ATTEMPTS):
            answer = self.graph.client.call(Trigger, "/wheel_drive/reset_fault")
            if answer.success or not answer.message.startswith(RULES["inputs"].text):
                break
            self.cycles(AFTER)
        assert answer.success, answer.message

    def measures_again(self, reset: bool) -> None:
        if reset:
            self.reset()
            self.graph.until(DriveStatus, lambda s: s.state < State.FAULT_REACTION_ACTIVE, 2.0)
        self.turn()
        self.cycles(SHORT)
        self.readable(SHORT)
        self.stop()

    def roll(self) -> None:
        """The wheel follows the plank, in the air."""
        graph = self.graph
        graph.plank(1)
        here = graph.until(EncoderState, lambda _: True, 1.0).plank_position
        graph.ask(
            SetWaveform,
            "/slip_sequencer/set_waveform",
            name="constant",
            parameters=["kappa"],
            values=[FASTEST_SLIP],
            start_position=here + STEP_AHEAD,
            effective_rolling_radius=0.31,
        )
        graph.ask(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
        graph.enable()
        graph.until(DriveStatus, lambda s: s.velocity > SPEED, 3.0)
        self.cycles(LONGER)
        assert self.shaft()["moving"]

    def persist(self, action: Callable[[], None]) -> None:
        """Make it again when it failed while the computer itself stalled."""

        def attempt() -> None:
            self.ready()
            action()

        undisturbed(lambda: GraphStalls(self.control.send, self.waits), attempt)

    def under_contract(self, name: str, break_it: Callable[[], int], stops: bool = True) -> None:
        """Around a fault, as `ethercat_contract.Contract`; `break_it` returns how many cycles it
        took."""
        self.ready()
        self.turn()
        enables = self.shaft()["enables"]
        took = break_it()
        self.well()
        wheel = self.shaft()
        check_shaft(name, stops, wheel, wheel["ran_on_ms"])
        assert wheel["enables"] == enables, "enabled by itself"
        self.readable(took + AFTER)
        if not stops:
            self.stop()
        self.measures_again(reset=stops)


KILLED = ("slip_sequencer", "measurement_hub", "encoders", "wheel_drive")
"""nodes that are killed one by one, so each has a process of its own"""


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FaultyGraph]:
    with (
        pytest.MonkeyPatch.context() as monkeypatch,
        emulated_graph(tmp_path_factory.mktemp("faults"), monkeypatch, KILLED) as graph,
        LongestWait() as waits,
    ):
        faulty = FaultyGraph(graph, waits)
        yield faulty
        faulty.hang_up()


@pytest.mark.parametrize(
    "scenario",
    [
        pytest.param(s, id=s.name, marks=[] if s.name in EVERY_DAY else [pytest.mark.long])
        for s in SCENARIOS
    ],
)
def test_fault(bench: FaultyGraph, scenario: Scenario) -> None:
    def break_it() -> int:
        arguments = OTHERWISE.get(scenario.name, scenario.arguments)
        bench.control.send(scenario.fault, **arguments)
        bench.cycles(scenario.cycles)
        return scenario.cycles

    bench.under_contract(scenario.name, break_it, scenario.stops)


def test_operator_gone(bench: FaultyGraph) -> None:
    """Whoever has claimed the bench and is not heard of any more."""
    bench.ready()
    bench.turn()
    enables = bench.shaft()["enables"]
    bench.graph.ask(Claim, "/operator/claim", client="somebody")
    bench.control.send("lose_share", share=0.0)  # notes the time
    bench.graph.until(DriveStatus, lambda s: s.stop_reason == RULES["heartbeat"].code, 2.0)
    bench.cycles(AFTER)
    wheel = bench.shaft()
    check_shaft("operator gone", True, wheel, wheel["ran_on_ms"] - 1e3 * HEARTBEAT_S)
    assert wheel["ran_on_ms"] > 1e3 * HEARTBEAT_S - WITHIN_MS, "stopped before its time"
    assert wheel["enables"] == enables
    bench.readable(AFTER)
    bench.measures_again(reset=True)


@pytest.mark.parametrize(
    "name",
    [
        "slip_sequencer",
        *(pytest.param(n, marks=pytest.mark.long) for n in KILLED if n != "slip_sequencer"),
    ],
)
def test_node_killed(bench: FaultyGraph, name: str) -> None:
    """The reference, the samples, or the commands themselves are no longer renewed."""
    graph = bench.graph
    bench.persist(bench.roll)
    graph.start_recording(f"killed_{name}", {"measurement": "slip"})
    bench.cycles(SHORT)
    enables = bench.shaft()["enables"]
    assert bench.shaft()["moving"]
    node = graph.nodes.running.pop(name)
    node.kill()
    bench.control.send("lose_share", share=0.0)  # notes the time
    node.wait()
    bench.cycles(AFTER)
    wheel = bench.shaft()
    graph.nodes.start_process(name)
    bench.everybody_speaks()
    check_shaft(f"{name} killed", True, wheel, wheel["ran_on_ms"])
    graph.plank(0)
    bench.readable(SHORT, status="stopped")
    assert bench.shaft()["enables"] == enables
    if name == "slip_sequencer":
        graph.is_at_present(SequencerState)
    bench.persist(lambda: bench.measures_again(reset=False))


def lost(bench: FaultyGraph, word: str) -> None:
    """A process behind the bus is killed under a running measurement."""
    bench.ready()
    bench.turn()
    bench.cycles(LONGER)
    pid, _ = bench.graph.process(word)
    os.kill(pid, signal.SIGKILL)
    bench.graph.last_word(DriveStatus, lambda s: s.stop_reason == RULES["inputs"].code)


def start_again(bench: FaultyGraph) -> None:
    """The bus and what is behind it; nothing is enabled by that."""
    nodes = bench.graph.nodes
    nodes.start_process("ethercat_bus")
    bench.graph.client.wait_connected(nodes)
    bench.find_emulator()
    bench.cycles(AFTER)
    wheel = bench.shaft()
    assert wheel["enables"] == 0 and wheel["last_moving_ns"] == -1
    bench.persist(lambda: bench.measures_again(reset=False))


def test_bus_process_killed(bench: FaultyGraph) -> None:
    """The node ends, since no bus comes back by itself; how the shaft stops is shown without a
    graph."""
    node = bench.graph.nodes.running["ethercat_bus"]
    lost(bench, "flatplank_hw.ethercat.master")
    assert node.wait(30.0) == 1
    assert "the bus process has ended" in bench.graph.nodes.log.read_text()
    bench.readable(SHORT)
    start_again(bench)


def test_emulator_killed(bench: FaultyGraph) -> None:
    """All slaves and the plant are gone for good."""
    node = bench.graph.nodes.running["ethercat_bus"]
    lost(bench, "flatplank_sim.emulator")
    bench.readable(SHORT)
    node.send_signal(signal.SIGINT)
    assert node.wait(30.0) == 0
    start_again(bench)
