# SPDX-License-Identifier: Apache-2.0
"""Measurements are checked before anything moves, and plans do things in the safe order."""

import math

import pytest

from flatplank_control.runner import steps as S
from flatplank_control.runner.conditions import QUANTITIES
from flatplank_control.runner.measurement import Measurement, from_mapping
from flatplank_control.runner.plans import plan_of
from flatplank_data.limits import LIMITS

ON_THE_ROAD = ["free_rolling", "slip"]


@pytest.fixture(params=ON_THE_ROAD)
def steps(request):
    return list(plan_of(Measurement(measurement=request.param, kappa=0.05, start=2)))


def first(steps, kind, **fields):
    return next(
        k
        for k, step in enumerate(steps)
        if isinstance(step, kind) and all(getattr(step, n) == v for n, v in fields.items())
    )


def test_the_tire_is_unloaded_before_the_plank_returns_and_loaded_after_the_wheel_is_turned(steps):
    unload = first(steps, S.Manual, quantity="unload")
    back = first(steps, S.Plank, direction=-1)
    turned = first(steps, S.MoveTo, angle_deg=120.0)
    load = first(steps, S.Manual, quantity="load", value=3700.0)
    assert unload < back < turned < load < first(steps, S.Plank, direction=1)


def test_angles_are_set_while_the_tire_is_unloaded(steps):
    load = first(steps, S.Manual, quantity="load")
    for quantity in ("steer_deg", "road_camber_deg"):
        assert first(steps, S.Manual, quantity=quantity) < load


def test_a_run_is_described_before_the_plank_moves_and_closed_after_it_rests(steps):
    record, forward = first(steps, S.Record), first(steps, S.Plank, direction=1)
    assert first(steps, S.Arm) < record < forward
    assert isinstance(steps[-1], S.StopRecord)
    assert steps[-1].status == "complete"
    stops = [k for k, s in enumerate(steps) if isinstance(s, S.Plank) and s.direction == 0]
    assert stops[-1] > forward


def test_every_manual_step_has_a_prompt_and_a_check(steps):
    for step in steps:
        if isinstance(step, S.Manual):
            assert QUANTITIES[step.quantity].prompt.format(value=step.value)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ({"kapa": 0.1}, "unknown key 'kapa'; the nearest is 'kappa'"),
        ({"kappa": math.nan}, "kappa is nan, must be finite"),
        (
            {"kappa": 2.0},
            "kappa is 200 % (kappa = 2), must be within {:g} .. {:g} %".format(
                *(100.0 * end for end in LIMITS["kappa"].bounds)
            ),
        ),
        ({"fz": 9000}, "fz is 9000 N, must be within 0 .. 8000"),
        ({"effective_rolling_radius": -0.3}, "effective_rolling_radius is -0.3"),
        ({"start": 4}, "start is 4, must be 1, 2 or 3"),
        ({"waveform": "stepp"}, "waveform is 'stepp'; the nearest is 'step'"),
        ({"step_position": 4.15}, "the slip would never be given"),
        ({"end_position": 4.5}, "end_position is 4.5 m, must be within 0 .. 4.2"),
        ({"tire": 5}, "tire is 5, must be text"),
    ],
)
def test_what_cannot_be_measured_is_refused_in_one_line(data, reason):
    with pytest.raises(ValueError, match="plan.yaml: ") as error:
        from_mapping(data, "plan.yaml")
    assert reason in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_kind_of_measurement_names_the_known_ones():
    with pytest.raises(ValueError, match="known are camber_sweep, .*free_rolling, .*slip"):
        plan_of(Measurement(measurement="spin"))


def test_the_record_of_a_step_says_what_was_asked_for():
    record = Measurement(kappa=-0.02, alpha_deg=1.0).record()
    assert record["waveform"] == {"name": "step"}
    assert record["step_position"] == 1.5
    assert Measurement(measurement="free_rolling").record()["effective_rolling_radius"] is None
