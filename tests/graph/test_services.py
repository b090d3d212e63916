# SPDX-License-Identifier: Apache-2.0
"""Service calls with bad values are refused with the reason; parameter files are checked."""

import math
import subprocess
import sys

import pytest
from bench_graph import graph
from domains import loopback, next_domain
from std_srvs.srv import Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_control.recording.bus_cycles import BEHIND_NS
from flatplank_data.waveforms import MAX_SLIP
from flatplank_msgs.srv import (
    Advance,
    Claim,
    LoadParasiticFit,
    MoveTo,
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetSlipStep,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)

pytestmark = pytest.mark.graph

CYCLES_BEHIND = BEHIND_NS // 4_000_000
STEP = {"kappa": 0.05, "start_position": 1.0, "effective_rolling_radius": 0.31}
PLACE = {"start_position": 1.0, "effective_rolling_radius": 0.31}
BEYOND = MAX_SLIP + 0.01
REFUSED = [
    (SetSlipStep, "/slip_sequencer/set_slip_step", STEP | {"kappa": math.nan}, "nan"),
    (SetSlipStep, "/slip_sequencer/set_slip_step", STEP | {"kappa": BEYOND}, f"{MAX_SLIP:g}"),
    (SetSlipStep, "/slip_sequencer/set_slip_step", STEP | {"kappa": -BEYOND}, f"{MAX_SLIP:g}"),
    (
        SetSlipStep,
        "/slip_sequencer/set_slip_step",
        STEP | {"effective_rolling_radius": -0.3},
        "radius",
    ),
    (
        SetSlipStep,
        "/slip_sequencer/set_slip_step",
        STEP | {"start_position": 9.0},
        "step_position is 9 m, must be within 0 .. 4.2",
    ),
    (
        SetWaveform,
        "/slip_sequencer/set_waveform",
        {"name": "sinus", "start_position": 1.0, "effective_rolling_radius": 0.31},
        "nearest is 'sine'",
    ),
    (SetOperationMode, "/wheel_drive/set_operation_mode", {"mode": "torqe"}, "torque"),
    (
        SetOperationMode,
        "/wheel_drive/set_operation_mode",
        {"mode": "velocity", "value": math.inf},
        "inf",
    ),
    (MoveTo, "/wheel_drive/move_to", {"angle_deg": 120.0}, "enable"),
    (LoadParasiticFit, "/measurement_hub/load_parasitic_fit", {"file": "/no/such"}, "no/such"),
    (StartRecording, "/recorder/start", {"name": "../out", "record": "tire: T"}, "../out"),
    (StartRecording, "/recorder/start", {"name": "a", "record": "tyre: T"}, "tyre"),
    (SetValue, "/simulated_plant/load_to", {"value": math.nan}, "nan"),
    (SetValue, "/simulated_plant/set_steer_deg", {"value": 400.0}, "must be within -90 .. 90"),
    (
        SetWaveform,
        "/slip_sequencer/set_waveform",
        {"name": "step", "parameters": ["kappa"] * 2, "values": [0.02, 0.05]} | PLACE,
        "twice",
    ),
    (SetOperationMode, "/wheel_drive/set_operation_mode", {"mode": "follow"}, "follow"),
    (SetValue, "/wheel_drive/set_trigger", {"value": 1e-9}, "1e-09"),
    (Advance, "/simulated_plant/advance", {"cycles": 2**64 - 1}, "cycles"),
    (SetSlipStep, "/slip_sequencer/set_slip_step", STEP | {"kappa": 9.0}, "within -50 .. 50 %"),
    (
        SetSlipStep,
        "/slip_sequencer/set_slip_step",
        STEP | {"effective_rolling_radius": 1e30},
        "1e+30 m, must be within",
    ),
    (SetWaveform, "/slip_sequencer/set_waveform", {"name": ""} | PLACE, "known are"),
    (SetWaveform, "/slip_sequencer/set_waveform", {"name": "a\nb"} | PLACE, "known are"),
    (SetWaveform, "/slip_sequencer/set_waveform", {"name": "x" * 9000} | PLACE, "known are"),
    (SetOperationMode, "/wheel_drive/set_operation_mode", {"mode": "slip\n"}, "the nearest is"),
    (SetValue, "/wheel_drive/set_trigger", {"value": math.inf}, "must be finite"),
    (SetValue, "/simulated_plant/load_to", {"value": -1e30}, "must be within 0 .. 8000"),
    (PlankSwitch, "/simulated_plant/plank", {"direction": 7}, "not -1, 0 or 1"),
    (PlankSwitch, "/simulated_plant/plank", {"direction": 1, "stop_at": 1e30}, "must be within"),
    (SetPace, "/simulated_plant/set_pace", {"pace": ""}, "one of realtime"),
    (StartRecording, "/recorder/start", {"name": "x" * 9000, "record": "tire: T"}, "not a name"),
    (StopRecording, "/recorder/stop", {"status": "nonsense"}, "start first"),
    (Claim, "/operator/claim", {"client": "x" * 9000}, "at most 200"),
    (LoadParasiticFit, "/measurement_hub/load_parasitic_fit", {"file": ""}, "no file is named"),
]
NO_PLANS = {
    "kappa: 9": "kappa is 900 % (kappa = 9), must be within -50 .. 50 %",
    "kappa: .nan": "must be finite",
    "{kappa: 0.02, effective_rolling_radius: -1}": "must be within 0.175",
    "{kappa: 0.02, step_position: 9}": "must be within 0 .. 4.2",
    "{kappa: 0.02, step_position: 2, end_position: 1}": "is not behind",
    "{kappa: 0.02, tire: ''}": "name the tire",
    "{kappa: 0.02, name: ../x}": "not a name for a measurement",
    "{measurement: nonsense}": "known are",
}
"""goals that are refused before anything moves"""


def test_bad_requests_are_refused_with_a_reason_and_change_nothing(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, separate=("encoders",)) as bench:
        bench.advance(10)
        for kind, name, fields, reason in REFUSED:
            response = bench.client.call(kind, name, **fields)
            assert not response.accepted, name
            assert reason in response.reason, (name, response.reason)
            assert "\n" not in response.reason and len(response.reason) < 700
        for plan, reason in NO_PLANS.items():
            with pytest.raises(BenchError) as refused:
                bench.client.measure(plan, simulated=True)
            assert reason in str(refused.value) and "\n" not in str(refused.value), plan
        assert bench.advance(0) < 20, "no goal has moved the held bus"
        # a start behind the plank, a tare over a moving plank
        bench.roll()
        late = bench.client.call(
            SetSlipStep, "/slip_sequencer/set_slip_step", **(STEP | {"start_position": 0.0})
        )
        assert not late.accepted and "behind the plank" in late.reason
        tare = bench.client.call(Trigger, "/measurement_hub/tare")
        assert not tare.success and "moves" in tare.message
        assert bench.wheel_turns(), "the step that was set before still holds"
        # a bag would lack what a node that is still known does not say: in lockstep the bus waits
        bench.call(SetPace, "/simulated_plant/set_pace", pace="realtime", batch=1)
        bench.kill("encoders")
        since = bench.advance(0)
        while bench.advance(0) < since + 2 * CYCLES_BEHIND:
            bench.client.spin(0.2)
        start = bench.client.call(StartRecording, "/recorder/start", name="a", record="tire: T")
        assert not start.accepted and "/encoders/state" in start.reason
        assert not list(bench.data.iterdir())


@pytest.mark.parametrize(
    ("node", "text", "reason"),
    [
        ("flatplank_hw.nodes.measurement_hub", "et_valu: 0.03", "the nearest is 'et_value'"),
        ("flatplank_hw.nodes.wheel_drive", "gear_ratio: -1.0", "gear_ratio"),
        ("flatplank_sim.nodes.simulated_plant", "tire: tojo", "toyo"),
        ("flatplank_control.nodes.slip_sequencer", "speed: 1.0", "unknown parameter 'speed'"),
    ],
)
def test_a_bad_parameter_file_is_refused_when_the_node_configures(tmp_path, node, text, reason):
    file = tmp_path / "parameters.yaml"
    file.write_text(f"/**:\n  ros__parameters:\n    {text}\n", encoding="utf-8")
    import os

    done = subprocess.run(
        [sys.executable, "-m", node, "--ros-args", "--params-file", str(file)],
        env={**os.environ, **loopback(next_domain())},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert reason in done.stderr
    assert "Traceback" not in done.stderr
