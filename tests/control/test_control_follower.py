# SPDX-License-Identifier: Apache-2.0
"""The follower of the road: travel, lost travel, corrections, encoders that disagree."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from test_control_sequencer import RE, TURNS, P, V, following, sample

from flatplank_control.sequencer import SlipSequencer
from flatplank_control.sequencer.sequencer import Follower


def speeds(s: SlipSequencer, cycles: int, **fields) -> list[float]:
    """References of a wheel that stays where it is while the road moves 0.5 mm per cycle."""
    return [s.step(sample(k + 1, 5e-4 * (k + 1), **fields)).value for k in range(cycles)]


def test_lost_travel_is_recovered_at_its_rate_until_the_road_has_gone_far_enough():
    free = V / RE
    found = speeds(following(), 220)
    # by hand: the lost angle grows by 0.5 mm / RE per cycle
    assert found[0] == pytest.approx(free + P.follow_rate * 5e-4 / RE)
    assert found[1] == pytest.approx(free + P.follow_rate * 1e-3 / RE)
    assert found[100] == pytest.approx(1.5 * free)
    assert found[198] > free
    assert found[201] == found[-1] == pytest.approx(free)


def test_the_second_encoder_of_the_road_is_followed_where_it_is_fitted():
    s = following(1.0, use_road_encoder=True)
    ahead = s.step(sample(2, 0.0, road_position=1.0005)).value
    assert ahead == pytest.approx(V / RE + P.follow_rate * 5e-4 / RE)
    assert speeds(following(use_road_encoder=True), 1)[0] > V / RE


def test_the_travel_is_that_of_the_road_behind_the_error_of_rack_and_pinion():
    mesh = {"mesh_turn_cos": 3e-5, "mesh_turn_sin": -4e-5, "mesh_tooth_cos": -5e-6,
            "mesh_tooth_sin": 1.2e-5}  # fmt: skip
    p = replace(P, follow_until=0.5, road_scale=1.001, **mesh)
    follower = Follower(p)
    read = 0.2 + V / p.rate_hz * np.arange(2000)
    for n, position in enumerate(read):
        follower.step(sample(n, position), 1.0 / RE)
    phase_turn, phase_tooth = math.atan2(-4.0, 3.0), math.atan2(1.2, -0.5)
    true = [
        1.001 * x + 5e-5 * math.cos(x / p.pinion_pitch_radius - phase_turn)
        + 1.3e-5 * math.cos(math.tau * x / p.tooth_pitch - phase_tooth)
        for x in (read[0], read[-1])
    ]  # fmt: skip
    assert follower.travel == pytest.approx(true[1] - true[0], rel=1e-9)
    assert abs(follower.travel - 1.001 * (read[-1] - read[0])) > 1e-6


def follower(**parameters) -> Follower:
    """A follower that has seen a resting plank."""
    f = Follower(replace(P, follow_until=0.5, **parameters))
    assert f.step(sample(0, 0.2, 0.0), TURNS) == 0.0
    return f


def test_a_resting_plank_that_creeps_has_no_travel_until_it_moves():
    f = follower()
    for n, position in enumerate((0.2004, 0.1997, 0.2003)):
        assert f.step(sample(n, position, 0.0, wheel_angle=0.01 * n), TURNS) == 0.0
        assert f.travel == 0.0
    f.step(sample(4, 0.2008, wheel_angle=0.02), TURNS)
    assert f.travel == pytest.approx(5e-4)
    assert f.lost == pytest.approx(5e-4 * TURNS), "from the angle at the start on"
    f.step(sample(5, 0.2010, 0.0, wheel_angle=0.021), TURNS)
    assert f.travel == pytest.approx(7e-4), "a plank that rests in a run has travelled"
    assert f.lost == pytest.approx(7e-4 * TURNS - 1e-3)


def test_a_follower_that_first_sees_a_moving_plank_starts_there():
    f = Follower(replace(P, follow_until=0.5))
    assert f.step(sample(0, 1.0, wheel_angle=3.0), TURNS) == 0.0
    assert f.step(sample(1, 1.0005, wheel_angle=3.0), TURNS) == pytest.approx(
        P.follow_rate * 5e-4 * TURNS
    )


@pytest.mark.parametrize(
    ("position", "travelled"),
    [(0.2009, 9e-4), (0.1991, -9e-4), (0.2011, V / P.rate_hz), (0.0, V / P.rate_hz)],
)
def test_a_step_of_more_than_a_millimetre_is_a_new_zero_of_the_position(position, travelled):
    f = follower()
    f.step(sample(1, 0.2), TURNS)
    f.step(sample(2, position), TURNS)
    assert f.travel == pytest.approx(travelled, rel=1e-6)
    f.step(sample(3, position + 1e-4), TURNS)
    assert f.travel == pytest.approx(travelled + 1e-4, rel=1e-6)


def test_the_error_of_rack_and_pinion_goes_on_from_the_new_zero():
    f = follower(mesh_turn_sin=5e-5)
    f.step(sample(1, 0.2), TURNS)
    f.step(sample(2, 0.01), TURNS)
    before = f.travel
    assert before == pytest.approx(V / P.rate_hz)
    f.step(sample(3, 0.0105), TURNS)
    turned = [math.sin(x / P.pinion_pitch_radius) for x in (0.01, 0.0105)]
    by_hand = 5e-4 + 5e-5 * (turned[1] - turned[0])
    assert f.travel - before == pytest.approx(by_hand, rel=1e-9)


@pytest.mark.parametrize(
    ("angle", "share"),
    [(-1e-3, None), (1e-3, None), (-1.0, 0.5), (1.0, -0.25)],
)
def test_the_correction_is_the_lost_angle_within_half_and_a_quarter_of_the_speed(angle, share):
    f = follower()
    f.step(sample(1, 0.2), TURNS)
    found = f.step(sample(2, 0.2, wheel_angle=angle), TURNS)
    assert f.lost == pytest.approx(-angle)
    wanted = -P.follow_rate * angle if share is None else share * V * TURNS
    assert found == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("mismatch", "follows"),
    [(P.mismatch_limit, True), (-P.mismatch_limit, True), (1.01 * P.mismatch_limit, False),
     (-1.01 * P.mismatch_limit, False), (math.nan, False)],
)  # fmt: skip
def test_encoders_that_disagree_are_not_followed_and_the_travel_is_kept(mismatch, follows):
    f = follower()
    found = f.step(sample(1, 0.2005, mismatch=mismatch), TURNS)
    assert (found != 0.0) is follows
    assert f.travel == pytest.approx(5e-4)
    assert f.step(sample(2, 0.2005), TURNS) == pytest.approx(P.follow_rate * 5e-4 * TURNS)


@pytest.mark.parametrize("used", [True, False])
def test_the_plank_is_followed_where_the_road_encoder_is_not_to_be_used(used):
    f = Follower(replace(P, follow_until=0.5, use_road_encoder=used, road_scale=1.002))
    f.step(sample(0, 0.2, 0.0, road_position=1.0), TURNS)
    f.step(sample(1, 0.2005, road_position=1.0003), TURNS)
    assert f.travel == pytest.approx(3e-4 if used else 1.002 * 5e-4)


def test_a_reset_ends_the_travel():
    s = following()
    s.step(sample(1, 5e-4))
    assert s.step(sample(2, 5e-4)).value > V / RE
    s.reset()
    assert s.step(sample(3, 5e-4)).value == pytest.approx(V / RE)
    assert s.step(sample(4, 1e-3)).value == pytest.approx(V / RE + P.follow_rate * 5e-4 / RE)


def test_the_wanted_turn_has_slip_and_steering_angle():
    s = SlipSequencer(replace(P, follow_until=0.1))
    s.set_waveform("constant", {"kappa": 0.1}, 0.0, RE)
    s.step(sample(0, 0.0, 0.0, steer_angle=0.2))
    per_metre = math.cos(0.2) * 1.1 / RE
    found = s.step(sample(1, 5e-4, steer_angle=0.2)).value
    assert found == pytest.approx((V + P.follow_rate * 5e-4) * per_metre)
    found = s.step(sample(2, 5e-4, steer_angle=0.0)).value
    assert found == pytest.approx(V * 1.1 / RE + P.follow_rate * 5e-4 * per_metre)


def test_the_slip_begins_at_the_start_position():
    s = SlipSequencer(P)
    s.set_waveform("constant", {"kappa": 0.1}, 1.5, RE)
    for position, active in ((0.3, False), (1.4999, False), (1.5, True), (2.5, True)):
        s.step(sample(0, position))
        state = s.state
        assert state.active is active
        assert state.reference_slip == (0.1 if active else 0.0)
        assert state.distance == pytest.approx(position - 1.5)
        assert state.start_position == 1.5 and state.effective_rolling_radius == RE
        assert state.reference_velocity == pytest.approx(V / RE * (1.1 if active else 1.0))
