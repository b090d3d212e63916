# SPDX-License-Identifier: Apache-2.0
"""A node that dies leaves a stopped wheel, a closed bag, and a bench that measures again."""

import signal
from pathlib import Path

import pytest
from bench_graph import graph
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import SetBool, Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_data.campaign import Campaign
from flatplank_data.run_record import load_record
from flatplank_msgs.srv import Advance, PlankSwitch

pytestmark = pytest.mark.graph
HUNDRED_MS = 25
LONG = pytest.mark.long
SHORT = {"kappa": 0.02, "step_position": 0.02, "end_position": 0.04}


def measures_again(bench) -> None:
    (bag,) = bench.client.measure(SHORT, simulated=True)
    assert load_record(Path(bag)).status == "complete"
    assert load_record(Path(bag)).cycles_lost == 0


@pytest.mark.parametrize(
    "name",
    [
        "wheel_drive",
        "free_rolling_controller",
        *(pytest.param(n, marks=LONG) for n in ("measurement_hub", "encoders", "slip_sequencer")),
    ],
)
def test_a_killed_node_stops_the_wheel_within_100_ms_and_the_next_measurement_works(
    name, tmp_path, monkeypatch
):
    with graph(tmp_path, monkeypatch, separate=(name,)) as bench:
        mode = "free_rolling" if name == "free_rolling_controller" else "slip"
        bench.roll(mode, record="killed")
        assert bench.wheel_turns()
        # what a killed node had not sent yet is lost
        bench.wait_written(bench.data / "killed", mode)
        bench.kill(name)
        bench.advance(HUNDRED_MS)
        assert not bench.wheel_turns()
        assert bench.stop_recording().cycles_lost == 0
        (run,) = Campaign.load(bench.data / "killed").runs
        assert len(run.table(check=False)["time"]) > 100
        bench.call(PlankSwitch, "/simulated_plant/plank", direction=0, fast=True)
        bench.processes.start_process(name)
        bench.client.wait_connected(bench.processes)
        if name == "wheel_drive":
            # the drive's own watchdog has tripped: it wants an explicit reset
            with pytest.raises(BenchError, match="reset it first"):
                measures_again(bench)
            bench.call(Trigger, "/wheel_drive/reset_fault")
            bench.advance(100)
        measures_again(bench)


@pytest.mark.parametrize("name", [pytest.param("measurement_hub", marks=LONG), "wheel_drive"])
def test_a_node_that_the_computer_holds_up_is_waited_for_and_nothing_trips(
    name, tmp_path, monkeypatch
):
    with graph(tmp_path, monkeypatch, separate=(name,)) as bench:
        told = bench.listen(DiagnosticArray, "/diagnostics")
        bench.roll()
        process = bench.processes.running[name]
        process.send_signal(signal.SIGSTOP)
        asked = bench.client.ask(Advance, "/simulated_plant/advance", cycles=100)
        while not any("bus_waits" in str(message) for message in told):
            bench.client.spin(0.5)
        assert not asked.done()
        process.send_signal(signal.SIGCONT)
        while not asked.done():
            bench.client.spin(0.5)
        assert bench.wheel_turns()
        bench.call(PlankSwitch, "/simulated_plant/plank", direction=0, fast=True)


def test_a_killed_recorder_leaves_a_bag_that_is_mended_at_the_next_start(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=("recorder",)) as bench:
        bench.roll(record="cut")
        bench.advance(500)
        bench.kill("recorder")
        assert bench.wheel_turns(), "a recorder is not needed to hold the slip"
        bench.processes.start_process("recorder")
        bench.client.wait_connected(bench.processes)
        assert load_record(bench.data / "cut").status == "interrupted"
        assert (bench.data / "cut" / "metadata.yaml").is_file()
        bench.call(PlankSwitch, "/simulated_plant/plank", direction=0, fast=True)
        measures_again(bench)


def test_a_killed_plant_is_named_and_what_was_recorded_is_kept(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=("simulated_plant",)) as bench:
        bench.roll(record="cut")
        bench.wait_written(bench.data / "cut")
        plant = bench.processes.running["simulated_plant"]
        plant.kill()
        plant.wait()
        reason = bench.processes.why_ended()
        assert reason and "simulated_plant" in reason and "SIGKILL" in reason
    assert load_record(bench.data / "cut").status in ("interrupted", "stopped")
    (run,) = Campaign.load(bench.data / "cut").runs
    assert len(run.table(check=False)["time"]) > 100


@pytest.mark.long
def test_a_killed_runner_moves_nothing_more_and_the_next_measurement_works(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=("measurement_runner",)) as bench:

        def kill(_feedback) -> None:
            if "measurement_runner" in bench.processes.running:
                bench.kill("measurement_runner")

        with pytest.raises(BenchError, match="the runner has gone"):
            bench.client.measure(SHORT, simulated=True, hear=kill)
        bench.processes.start_process("measurement_runner")
        bench.client.wait_connected(bench.processes)
        measures_again(bench)


@pytest.mark.parametrize("mode", ["slip", "free_rolling"])
def test_the_emergency_stop_stops_plank_and_wheel(mode, tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch) as bench:
        bench.roll(mode)
        assert bench.wheel_turns()
        bench.call(SetBool, "/simulated_plant/emergency_stop", data=True)
        bench.advance(HUNDRED_MS)
        assert not bench.wheel_turns()
        with pytest.raises(BenchError):
            bench.client.measure(SHORT, simulated=True)
        bench.call(SetBool, "/simulated_plant/emergency_stop", data=False)
        assert not bench.wheel_turns(), "nothing is enabled by itself"
        measures_again(bench)
