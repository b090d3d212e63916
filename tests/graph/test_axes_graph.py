# SPDX-License-Identifier: Apache-2.0
"""Driven axes on the graph: the load is held under braking, the standing tire is parked."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from bench_graph import graph
from std_srvs.srv import SetBool
from test_lab import drive_state

from flatplank_control.bench.results import COLUMNS
from flatplank_control.nodes.client import BenchError
from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES
from flatplank_hw.nodes.qos import STREAM
from flatplank_msgs.msg import DriveStatus
from flatplank_msgs.srv import Claim, SetOperationMode

pytestmark = pytest.mark.graph
HELD = """
measurement: slip
kappa: -0.1
fz: 3700.0
step_position: 0.03
end_position: 0.23
hold_load: true
optical_trigger: 0.05
"""
PARKING = """
measurement: parking
profile_parameters: {amplitude: 0.03, rate: 0.03}
profile_time: 4.5
"""


def columns(path):
    from flatplank_data.campaign import Run
    from flatplank_data.run_record import RunRecord
    from flatplank_data.store import open_store

    names = [*COLUMNS, "steer_angle", "mz"]
    return Run(RunRecord(file=path.name), open_store(path.parent)).table(names).columns


def messages_of(bag) -> dict[str, int]:
    """Recorded topics and the number of their messages."""
    content = yaml.safe_load((bag / "metadata.yaml").read_text())
    topics = content["rosbag2_bagfile_information"]["topics_with_message_count"]
    return {t["topic_metadata"]["name"]: t["message_count"] for t in topics}


def steering_stops_with_its_operator(bench):
    """The wheel's drive answers the claim; the steering's hears of it, and of no heartbeat."""
    seen = bench.listen(DriveStatus, "/steer_drive/status")

    bench.call(SetOperationMode, "/steer_drive/set_operation_mode", mode="velocity", value=0.01)
    bench.call(Claim, "/operator/claim", client="somebody")
    bench.call(SetBool, "/steer_drive/enable", data=True)
    assert bench.message_after(50, seen).velocity == pytest.approx(0.01, rel=0.05)
    stopped = bench.message_after(200, seen)
    assert (stopped.stop_reason, stopped.velocity) == (RULES["heartbeat"].code, 0.0)


def test_load_and_steering_are_led_by_their_nodes(tmp_path, monkeypatch, capsys):
    soft = tmp_path / "plant.yaml"
    soft.write_text("defects: {load_change: {brake: 0.0097, drive: 0.004}}\n")
    setup = {"axes": ("vertical", "steer"), "plant_file": str(soft)}
    with graph(tmp_path, monkeypatch, **setup) as bench:
        measure = bench.client.measure
        data = str(bench.data)
        measure(HELD, simulated=True, folder=data)
        measure(PARKING, simulated=True, folder=data)
        with pytest.raises(BenchError, match="camber_drive.*is its node running"):
            measure("{measurement: camber_sweep, profile: sine}", simulated=True, folder=data)
        steering_stops_with_its_operator(bench)
    kept = messages_of(next(bench.data.glob("TOY_PARKING*")))
    of_every_cycle = kept["/wheel_drive/status"]
    for axis in setup["axes"]:
        assert kept[f"/{axis}_drive/status"] == kept[f"/{axis}_drive/joint_states"]
        assert kept[f"/{axis}_drive/status"] == of_every_cycle > 1000
        assert kept[f"/{axis}_drive/mode"] > 0
    assert kept["/steer_drive/reference"] > 1000
    assert "/operator/in_charge" in kept
    held = columns(next(bench.data.glob("TOY_REL_LNG*")))
    parked = columns(next(bench.data.glob("TOY_PARKING*")))
    worst = float(np.abs(np.convolve(held["fz"], np.ones(25) / 25, "valid") / 3700.0 - 1.0).max())
    with capsys.disabled():
        print(f"\nFz held on the graph at -10 %: worst {100 * worst:.2f} %")
    assert held["fx"].min() < -1500.0
    assert worst < 0.01
    assert np.ptp(parked["steer_angle"]) == pytest.approx(0.06, abs=0.004)
    assert np.ptp(parked["mz"]) > 20.0


def test_ctrl_c_stops_a_driven_axis(tmp_path, monkeypatch):
    parking = {
        "measurement": "parking",
        "profile_parameters": {"amplitude": 0.03, "rate": 0.03},
        "profile_time": 4.5,
    }
    said, seen = [], []

    def leave() -> None:
        enabled = bool(seen) and seen[-1].state == State.OPERATION_ENABLED
        if enabled and said and said[-1].startswith("parking on"):
            raise KeyboardInterrupt

    with graph(tmp_path, monkeypatch, axes=("steer",)) as bench:
        # the runner lets the bus make cycles here; nobody else may
        bench.client.node.create_subscription(
            DriveStatus, "/steer_drive/status", seen.append, STREAM
        )
        with pytest.raises(KeyboardInterrupt):
            bench.client.measure(parking, simulated=True, say=said.append, idle=leave)
        assert drive_state(bench, "steer_drive") != State.OPERATION_ENABLED
