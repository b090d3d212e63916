# SPDX-License-Identifier: Apache-2.0
"""Waveforms and the slip sequencer."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_data.params import ParameterError, from_mapping, parameter_infos, to_mapping
from flatplank_data.waveforms import MAX_SLIP, WAVEFORMS
from flatplank_hw.samples import EncoderSample

P = SequencerParameters(follow_until=0.0)
RE = 0.3108
BEYOND = MAX_SLIP + 0.01
V = P.commanded_speed


def sample(n: int, position: float, velocity: float = V, **fields) -> EncoderSample:
    values = {
        "wheel_angle": 0.0, "wheel_velocity": 0.0, "steer_angle": 0.0, "road_camber": 0.0,
        "road_position": math.nan, "motor_angle": 0.0, "motor_velocity": 0.0,
        "plank_moving": velocity != 0.0, "trigger": False, "mismatch": 0.0,
    }  # fmt: skip
    return EncoderSample(n, 4_000_000 * n, position, velocity, **{**values, **fields})


def with_step(kappa=0.05, start=1.5) -> SlipSequencer:
    s = SlipSequencer(P)
    assert s.set_slip_step(kappa, start, RE).accepted
    return s


@pytest.mark.parametrize("name", WAVEFORMS)
def test_every_waveform(name):
    """Contract: named, documented, pure, bounded, zero by default, parameters with bounds."""
    kind = WAVEFORMS[name]
    assert kind.name == name
    assert kind.__doc__
    distances = np.linspace(0.0, 5.0, 501)
    assert all(kind().slip(d) == 0.0 for d in distances)
    slips = {i.name: 0.2 for i in parameter_infos(kind) if i.bounds == (-MAX_SLIP, MAX_SLIP)}
    assert slips
    wave = from_mapping(kind, slips, name)
    values = [wave.slip(d) for d in distances]
    assert values == [wave.slip(d) for d in distances]
    assert 0.0 < np.abs(values).max() <= MAX_SLIP
    assert from_mapping(kind, to_mapping(wave), name) == wave
    s = SlipSequencer(P)
    assert s.set_waveform(name, slips, 1.0, RE).accepted
    s.step(sample(0, 0.5))
    assert s.state.reference_slip == 0.0
    s.step(sample(1, 1.4))
    assert s.state.reference_slip == wave.slip(1.4 - 1.0)


@pytest.mark.parametrize("name", WAVEFORMS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, BEYOND, -BEYOND])
def test_every_waveform_refuses_bad_slips(name, bad):
    for info in parameter_infos(WAVEFORMS[name]):
        if info.bounds == (-MAX_SLIP, MAX_SLIP):
            answer = SlipSequencer(P).set_waveform(name, {info.name: bad}, 1.0, RE)
            assert not answer.accepted
            assert info.name in answer.reason


def test_shapes():
    sine = WAVEFORMS["sine"](amplitude=0.1, wavelength=2.0, offset=0.05)
    assert [sine.slip(d) for d in (0.0, 0.5, 1.5)] == pytest.approx([0.05, 0.15, -0.05])
    triangle = WAVEFORMS["triangle"](amplitude=0.1, wavelength=2.0, offset=0.0)
    distances = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0)
    assert [triangle.slip(d) for d in distances] == pytest.approx([0.0, 0.05, 0.1, 0.0, -0.1, 0.0])
    double = WAVEFORMS["double_step"](kappa_1=-0.01, kappa_2=0.02, length=0.5)
    assert [double.slip(d) for d in (0.0, 0.49, 0.5, 3.0)] == [-0.01, -0.01, 0.02, 0.02]
    step = WAVEFORMS["step"](kappa=0.1, length=1.0)
    assert [step.slip(d) for d in (0.0, 0.99, 1.0)] == [0.1, 0.1, 0.0]


def test_peak_of_sine_and_triangle_is_limited():
    for name in ("sine", "triangle"):
        values = {"amplitude": 0.3, "offset": 0.3}
        answer = SlipSequencer(P).set_waveform(name, values, 1.0, RE)
        assert answer.reason == f"waveform {name}: the slip reaches 60 %, beyond 50 %"


def test_reference_speed():
    s = with_step()
    before = s.step(sample(0, 0.2))
    assert before._replace(value=0.0) == (0, 0, "slip", 0.0, True)
    assert before.value == pytest.approx(V / RE, rel=1e-12)
    after = s.step(sample(1, 1.5, steer_angle=0.1))
    assert after.value == pytest.approx(V * math.cos(0.1) * 1.05 / RE)
    assert s.state.active
    assert s.state.distance == 0.0


def test_the_wrong_speed_switch_makes_the_reference_invalid():
    s = with_step()
    for n in range(200):
        reference = s.step(sample(n, 0.001 * n, velocity=0.0015))
        assert reference.valid == (n * 0.004 <= P.speed_patience)
    assert s.step(sample(200, 0.3)).valid
    assert s.step(sample(201, 0.3, velocity=0.0)).valid
    slow = SlipSequencer(SequencerParameters(follow_until=0.0, commanded_speed=0.0015))
    slow.set_slip_step(0.05, 1.0, RE)
    assert all(slow.step(sample(n, 0.1, velocity=0.0015)).valid for n in range(300))


def test_measured_speed_can_be_used_instead():
    s = SlipSequencer(SequencerParameters(follow_until=0.0, use_measured_speed=True))
    s.set_slip_step(0.05, 1.0, RE)
    assert s.step(sample(0, 0.5, velocity=0.0311)).value == pytest.approx(0.0311 / RE)


@pytest.mark.parametrize(("from_motor", "slip"), [(True, 0.05), (False, 0.02)])
def test_actual_slip_is_from_measured_velocities(from_motor, slip):
    s = SlipSequencer(SequencerParameters(follow_until=0.0, slip_from_motor=from_motor))
    s.set_slip_step(0.05, 1.0, RE)
    v = 0.03096
    s.step(
        sample(
            0, 2.0, velocity=v, wheel_velocity=v * 1.02 / RE,
            motor_velocity=v * 1.05 / RE * P.gear_ratio,
        )
    )  # fmt: skip
    assert s.state.actual_slip == pytest.approx(slip)
    s.step(sample(1, 2.0, velocity=0.0))
    assert math.isnan(s.state.actual_slip)


def test_without_a_waveform_the_reference_is_not_valid():
    s = SlipSequencer(P)
    assert s.step(sample(0, 0.1)) == (0, 0, "slip", 0.0, False)
    assert math.isnan(s.state.actual_slip)


@pytest.mark.parametrize(
    ("kappa", "start", "radius", "reason"),
    [
        (math.nan, 1.5, RE, "kappa is nan, must be finite"),
        (
            BEYOND,
            1.5,
            RE,
            f"kappa is {100 * BEYOND:g} % (kappa = {BEYOND:g}), must be within -50 .. 50 %",
        ),
        (-BEYOND, 1.5, RE, f"kappa is {-100 * BEYOND:g} %"),
        (0.05, math.nan, RE, "must be finite"),
        (0.05, 1.5, math.inf, "must be finite"),
        (0.05, 1.5, -0.3, "must be within 0.175 .. 0.387"),
        (0.05, 1.5, 0.0, "must be within 0.175 .. 0.387"),
        (0.05, 1.5, 0.51, "must be within 0.175 .. 0.387"),
        (0.05, 4.2, RE, "the end of the road"),
        (0.05, -0.1, RE, "must be within 0 .. 4.2"),
        (0.05, 0.9, RE, "behind the plank at 1.000 m"),
    ],
)
def test_refusals_leave_everything_as_it_was(kappa, start, radius, reason):
    s = with_step(0.02, 1.2)
    s.step(sample(0, 1.0))
    before = s.state
    answer = s.set_slip_step(kappa, start, radius)
    assert not answer.accepted
    assert reason in answer.reason
    s.step(sample(1, 1.0))
    assert s.state[:2] == before[:2]
    assert s.state[4:] == before[4:]


def test_unknown_names_give_the_nearest():
    s = SlipSequencer(P)
    assert "nearest is 'triangle'" in s.set_waveform("triangel", {}, 1.0, RE).reason
    assert "nearest is 'amplitude'" in s.set_waveform("sine", {"ampl": 0.1}, 1.0, RE).reason


def test_a_request_takes_effect_at_the_next_cycle():
    s = with_step(0.02, 0.0)
    for n in range(5):
        s.step(sample(n, 1.0))
    assert s.state.reference_slip == 0.02
    assert s.set_slip_step(0.1, 1.0, RE).cycle == 5
    s.step(sample(5, 1.0))
    assert s.state.reference_slip == 0.1


def test_a_sequencer_that_is_not_listened_to_still_knows_where_the_plank_is():
    s = with_step()
    s.step(sample(100, 4.1))
    assert not s.set_slip_step(0.05, 1.5, RE).accepted
    s.watch(-0.02, 900)
    assert s.set_slip_step(0.05, 1.5, RE).cycle == 901
    s.watch(2.0, 950)
    assert "behind the plank" in s.set_slip_step(0.05, 1.5, RE).reason


def test_reset_forgets_where_the_plank_was():
    s = with_step()
    s.step(sample(0, 4.1))
    assert not s.set_slip_step(0.05, 1.5, RE).accepted
    s.reset()
    assert s.step(sample(1, 1.6)).valid, "the waveform stays"
    s.reset()
    assert s.set_slip_step(0.05, 1.5, RE).accepted


def test_a_cycle_is_cheap():
    s = with_step()
    samples = [sample(n, n * 1e-4) for n in range(20000)]
    start = time.process_time()
    for e in samples:
        s.step(e)
    # 0.7 us on the machine where it was written; the bound only catches a change of kind
    assert (time.process_time() - start) / len(samples) < 20e-6


@pytest.mark.parametrize(("name", "values", "words"), [
    ("step", {"kappa": 0.05}, "step of +5 % at 1.5 m, r_e 310.8 mm"),
    ("sine", {"amplitude": 0.02, "wavelength": 0.5},
     "sine of amplitude +2 %, wavelength 0.5 m at 1.5 m, r_e 310.8 mm"),
    ("constant", {}, "constant of its defaults at 1.5 m, r_e 310.8 mm"),
])  # fmt: skip
def test_an_accepted_waveform_is_told_with_its_numbers(name, values, words):
    assert words in SlipSequencer(P).set_waveform(name, values, 1.5, RE).reason


def test_without_a_moving_plank_there_is_no_actual_slip():
    s = with_step()
    assert math.isnan(s.state.actual_slip)
    s.step(sample(0, 0.0, 0.0, wheel_velocity=0.1))
    assert math.isnan(s.state.actual_slip)
    s.step(sample(1, 0.1, motor_velocity=1.02 * V / RE * P.gear_ratio))
    assert s.state.actual_slip == pytest.approx(0.02)
    assert math.isnan(SlipSequencer(P).state.actual_slip)


TURNS = 1.0 / RE
"""of a freely rolling wheel [rad/m]"""


def test_before_a_waveform_the_state_is_empty():
    state = SlipSequencer(P).state
    assert (state.active, state.reference_slip, state.reference_velocity) == (False, 0.0, 0.0)
    assert all(math.isnan(x) for x in (state.distance, state.start_position))
    assert math.isnan(state.effective_rolling_radius) and math.isnan(state.actual_slip)
    assert SlipSequencer(P).waveform == {}


def test_the_waveform_that_was_set_last_is_kept_with_all_its_parameters():
    s = with_step(0.03, 1.2)
    known = {"name": "step", "start_position": 1.2, "effective_rolling_radius": RE}
    assert {k: s.waveform[k] for k in known} == known
    assert s.waveform["parameters"]["kappa"] == 0.03
    assert "length" in s.waveform["parameters"]
    kept = dict(s.waveform)
    assert not s.set_slip_step(0.05, 9.0, RE).accepted
    assert not s.set_waveform("sine", {"amplitude": 9.0}, 1.0, RE).accepted
    assert s.waveform == kept


def following(road: float = math.nan, **parameters) -> SlipSequencer:
    """A step that follows the travel of the road."""
    s = SlipSequencer(replace(P, follow_until=0.1, **parameters))
    assert s.set_slip_step(0.0, 1.5, RE).accepted
    s.step(sample(0, 0.0, 0.0, road_position=road))
    return s


def test_only_the_plank_speed_changes_while_it_runs():
    s = following()
    slow = replace(s.parameters, commanded_speed=0.02)
    s.set_constants(slow)
    assert s.step(sample(1, 0.0)).value == pytest.approx(0.02 / RE)
    for k in range(60):
        found = s.step(sample(2 + k, 5e-4 * (k + 1))).value
    assert found == pytest.approx(1.5 * 0.02 / RE), "the bound of the correction, too"
    with pytest.raises(ValueError, match="slip sequencer"):
        s.set_constants(replace(slow, follow_rate=1.0))
    assert s.parameters == slow
    plain = with_step()
    plain.set_constants(replace(P, commanded_speed=0.02))
    assert plain.step(sample(0, 0.1)).value == pytest.approx(0.02 / RE)


@pytest.mark.parametrize(
    ("share", "valid"), [(0.79, False), (0.81, True), (1.19, True), (1.21, False)]
)
def test_the_speed_may_differ_by_its_tolerance(share, valid):
    s = with_step()
    for n in range(200):
        reference = s.step(sample(n, 0.3, velocity=share * V))
    assert reference.valid is valid


def test_the_patience_begins_anew_after_every_good_speed():
    s = with_step()
    late = round(P.speed_patience / 0.004)
    for n in range(3 * late):
        off = n % late != 0
        assert s.step(sample(n, 0.3, velocity=0.5 * V if off else V)).valid


def test_the_actual_slip_is_along_the_wheel():
    s = with_step()
    s.step(sample(0, 0.3, steer_angle=0.3, motor_velocity=1.1 * V / RE * P.gear_ratio))
    assert s.state.actual_slip == pytest.approx(1.1 / math.cos(0.3) - 1.0)


def test_a_start_at_the_plank_is_accepted_and_one_behind_it_is_not():
    s = with_step()
    s.step(sample(0, 1.0))
    assert s.set_slip_step(0.05, 1.0, RE).accepted
    assert not s.set_slip_step(0.05, 0.999, RE).accepted


@pytest.mark.parametrize("high", [0.2, 0.19])
def test_limits_of_the_radius_that_leave_none_are_refused(high):
    with pytest.raises((ParameterError, ValueError), match="radius_min is not below radius_max"):
        SequencerParameters(radius_min=0.2, radius_max=high)
    assert SequencerParameters(radius_min=0.2, radius_max=0.3).radius_max == 0.3
