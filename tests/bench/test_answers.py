# SPDX-License-Identifier: Apache-2.0
"""An accepted request answers what is done, with numbers; nonsense is refused."""

import math
from types import SimpleNamespace

import pytest

from flatplank_control.nodes.source import named_values
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_control.steering_hold import AngleControl, AngleParameters
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_sim.nodes.operator_services import OperatorServices


def test_a_slip_step_says_slip_place_and_radius():
    sequencer = SlipSequencer(SequencerParameters())
    answer = sequencer.set_slip_step(0.05, 1.5, 0.3108)
    assert answer == (True, "step of +5 % at 1.5 m, r_e 310.8 mm, from cycle 0", 0)
    wave = {"amplitude": -0.02, "wavelength": 0.8}
    answer = sequencer.set_waveform("sine", wave, 1.0, 0.3108)
    assert answer.reason == (
        "sine of amplitude -2 %, wavelength 0.8 m at 1 m, r_e 310.8 mm, from cycle 0"
    )


def test_a_drive_says_what_it_does():
    drive = AxisDrive(DriveParameters())
    assert (
        drive.set_operation_mode("velocity", 0.1).reason
        == "mode velocity with 0.1 rad/s, from cycle 0"
    )
    assert drive.set_operation_mode("slip").reason == "mode slip, from cycle 0"
    assert drive.set_trigger(0.01).reason == (
        "the trigger output gives a pulse every 10 mm of road, from cycle 0"
    )
    assert drive.set_trigger(0.0).reason == "the trigger output is on, from cycle 0"
    assert "within 0.5 s" in drive.claim("page").reason
    for answer in (drive.disable(), drive.quick_stop(), drive.release(), drive.set_trigger(-1.0)):
        assert (
            answer.accepted
            and answer.reason.endswith(", from cycle 0")
            and len(answer.reason) > 20
        )


def test_further_nodes_say_what_they_do():
    assert "0 m, from cycle 0" in Encoders(EncoderParameters()).arm().reason
    hold = AngleControl(AngleParameters())
    assert hold.hold(math.radians(1.5)).reason == "the angle is held at +1.5 deg"
    assert "amplitude 0.02 rad" in hold.set_profile("sine", {"amplitude": 0.02}).reason


PLANK = SimpleNamespace(direction=1, fast=True, stop_at=4.1)


@pytest.mark.parametrize(
    ("service", "request_", "said"),
    [
        ("plank", PLANK, "goes forward, fast, to 4.1 m"),
        ("set_pressure_bar", SimpleNamespace(value=2.5), "pressure goes to 2.5 bar"),
        ("set_axle_height", SimpleNamespace(value=0.3), "axle height goes to 0.3 m"),
        ("emergency_stop", SimpleNamespace(data=True), "emergency stop is on"),
        ("unload", SimpleNamespace(), "lifts the wheel"),
    ],
)  # fmt: skip
def test_the_simulated_operator_says_what_moves(service, request_, said):
    served = {}
    node = SimpleNamespace(add_service=lambda _kind, name, call: served.update({name: call}))
    OperatorServices(node, lambda *_: None, lambda: 41)
    response = SimpleNamespace(accepted=None, reason="", cycle=0)
    served[f"simulated_plant/{service}"](request_, response)
    assert response.accepted and said in response.reason
    assert response.reason.endswith(", from cycle 42") and response.cycle == 42


@pytest.mark.parametrize("axis, rules, mode", [
    ("wheel", DriveParameters().rules, "follow"),
    ("vertical", ("inputs", "reference_gone"), "slip"),
    ("plank", ("inputs",), "follow"),
])  # fmt: skip
def test_a_mode_without_a_source_is_refused(axis, rules, mode):
    answer = AxisDrive(DriveParameters(axis=axis, rules=rules)).set_operation_mode(mode)
    assert answer == (False, f"the {axis} drive has no source for mode '{mode}'", -1)


@pytest.mark.parametrize("distance", [1e-9, math.nan, math.inf])
def test_pulses_that_no_encoder_can_place_are_refused(distance):
    assert not AxisDrive(DriveParameters()).set_trigger(distance).accepted


def test_a_parameter_given_twice_is_refused():
    request = SimpleNamespace(parameters=["kappa", "length", "kappa"], values=[0.1, 1.0, -0.1])
    with pytest.raises(ValueError, match="given twice: kappa"):
        named_values(request)
    with pytest.raises(ValueError, match="3 parameters and 2 values"):
        named_values(SimpleNamespace(parameters=["a", "b", "c"], values=[0.1, 1.0]))
