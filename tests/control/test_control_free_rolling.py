# SPDX-License-Identifier: Apache-2.0
"""The controller core: start, limits, anti-windup, settled, bad input."""

from __future__ import annotations

import math
import random
import time
from dataclasses import replace

import numpy as np
import pytest

import control
from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.free_rolling.design import design_gains
from flatplank_control.free_rolling.loop import margins
from flatplank_control.free_rolling.start import (
    CATCH_UP,
    MEASURE_STIFFNESS,
    OVER,
    Start,
    StiffnessEstimator,
)
from flatplank_hw.samples import EncoderSample, HubSample, Wrench

P = FreeRollingParameters(automatic=False)


def samples(n: int, fx: float, moving: bool = True, velocity: float = 0.03092):
    w = Wrench(fx, 0.0, 3700.0, 0.0, 0.0, 0.0)
    hub = HubSample(n, 4_000_000 * n, w, w, 0.3, 0.0, 3700.0, False, 0)
    v = velocity if moving else 0.0
    enc = EncoderSample(n, 4_000_000 * n, 0.1, v, 0, 0, 0, 0, math.nan, 0, 0, moving, False, 0.0)
    return hub, enc


def test_nothing_before_the_plank_moves_then_the_start_torque():
    c = FreeRollingController(P)
    for n in range(100):
        reference = c.step(*samples(n, 0.0, moving=False))
        assert reference == (n, 4_000_000 * n, "free_rolling", 0.0, True)
    first = c.step(*samples(100, 0.0)).value
    # the jump of PI and lead is that of their bilinear form
    jump = 50.0 * (P.proportional_gain + 0.5 * P.integral_gain / P.rate_hz)
    zero, pole = (1 + 2 * t * P.lead_time * P.rate_hz for t in (1.0, P.lead_alpha))
    assert first == pytest.approx(P.start_torque + jump * zero / pole)
    assert c.state.lead == pytest.approx(jump * zero / pole)
    assert c.state.error == 50.0


def test_a_new_controller_has_a_state_and_the_gains_of_its_parameters():
    c = FreeRollingController(P)
    assert c.state == (50.0, 0.0, 0.0, 0.0, 0.0, 0.0, False, False)
    assert c.gains == (P.proportional_gain, P.integral_gain, P.lead_time, P.lead_alpha)
    assert all(math.isnan(value) for value in c.tire)


def test_a_stopped_plank_resets():
    c = FreeRollingController(P)
    for n in range(500):
        c.step(*samples(n, -100.0))
    assert c.state.i > 0.1
    assert c.step(*samples(500, -100.0, moving=False)).value == 0.0
    fresh = FreeRollingController(P)
    assert c.step(*samples(501, 10.0)).value == fresh.step(*samples(501, 10.0)).value


def test_a_reversing_plank_gives_nothing():
    c = FreeRollingController(P)
    assert c.step(*samples(0, -100.0, velocity=-0.03)).value == 0.0


@pytest.mark.parametrize(("fx", "limit"), [(-1e4, P.torque_max), (1e4, P.torque_min)])
def test_limits_and_anti_windup(fx, limit):
    c = FreeRollingController(P)
    for n in range(2000):
        assert c.step(*samples(n, fx)).value == limit
    assert c.state.saturated
    wound = c.state.i
    assert abs(wound) < 0.1
    c.step(*samples(2000, 50.0))
    c.step(*samples(2001, 50.0))
    for n in range(2002, 2200):
        c.step(*samples(n, 50.0))
    assert not c.state.saturated
    assert c.state.output == pytest.approx(P.start_torque, abs=0.1)


def test_settled_needs_time_in_the_band():
    c = FreeRollingController(P)
    flags = []
    for n in range(4000):
        c.step(*samples(n, 51.0 if n > 500 else 200.0))
        flags.append(c.state.settled)
    first = flags.index(True)
    # the filtered error starts at 50 N, nears -150 N for 2 s, then -1 N, and must come to -2.5 N
    reached = 150.0 - 200.0 * math.exp(-2.0)
    fall = P.settled_filter * math.log((reached - 1.0) / 1.5) * 250
    assert first == pytest.approx(500 + fall + P.settled_time * 250, abs=10)
    assert all(flags[first:])


def test_bad_force_makes_the_reference_invalid_and_leaves_the_state():
    c = FreeRollingController(P)
    for n in range(100):
        c.step(*samples(n, 20.0))
    state = c.state
    assert not c.step(*samples(100, math.nan)).valid
    assert c.state == state
    assert c.step(*samples(101, 20.0)).valid


def test_rate_does_not_change_the_controller():
    slow, fast = FreeRollingController(P), FreeRollingController(replace(P, rate_hz=1000.0))
    for n in range(1000):
        slow.step(*samples(n, 30.0))
        for k in range(4):
            fast.step(*samples(4 * n + k, 30.0))
    assert fast.state.output == pytest.approx(slow.state.output, rel=1e-3)


def test_a_cycle_is_cheap():
    c = FreeRollingController(P)
    pairs = [samples(n, 30.0) for n in range(20000)]
    start = time.process_time()
    for hub, enc in pairs:
        c.step(hub, enc)
    # 1.1 us on the machine where it was written; the bound only catches a change of kind
    assert (time.process_time() - start) / len(pairs) < 20e-6


def test_the_gain_margin_is_that_of_the_smallest_rising_gain():
    """1 / (s + 1)^3: the margin is 8; with a gain of 2 it is 4."""
    s = control.tf("s")
    for gain in (1.0, 2.0):
        _, _, margin = margins(gain * 1.5 / (s + 1) ** 3)
        assert margin == pytest.approx(8.0 / (1.5 * gain), rel=1e-6)


def held_tire(n: int, x: float, stiffness: float = 4e5) -> tuple[float, EncoderSample]:
    """Force and encoders of a wheel that its gear holds, when the road has moved by x [m]."""
    _, encoders = samples(n, 0.0)
    return -stiffness * x, encoders._replace(plank_position=0.1 + x)


def test_the_start_estimates_the_stiffness_while_the_gear_holds_the_wheel():
    start = Start(P)
    step = 0.03092 / P.rate_hz
    torques = [start.step(*held_tire(n, step * n)) for n in range(20)]
    waiting = torques.index(next(t for t in torques if t != 0.0))
    assert start.stiffness == pytest.approx(4e5, rel=1e-6)
    # by hand: 450 N after 1.125 mm
    assert waiting == math.ceil(450.0 / 4e5 / step)
    assert all(t >= P.start_torque for t in torques[waiting:])


def test_the_tire_is_estimated_over_5_cm_although_the_lost_travel_is_made_up_before():
    """Its gains come into force without a jump of the torque."""
    stiffness, sigma, radius = 4e5, 0.3, 0.311
    c = FreeRollingController(replace(P, automatic=True))
    dx, x, angle, force, out, leads = 0.03092 / P.rate_hz, 0.0, 0.0, 0.0, [], []
    _, at_rest = samples(0, 0.0)
    for n in range(500):
        encoders = at_rest._replace(
            plank_position=x,
            wheel_angle=5.0 + angle,
            motor_velocity=0.03092 / radius * P.gear_ratio,
        )
        hub = samples(n, force)[0]
        out.append((x, c.step(hub, encoders).value, c.tire.effective_radius))
        leads.append(c.state.lead)
        # the wheel makes up its lost travel at 8 1/s once it has a torque
        wanted = x + 50.0 / stiffness - P.effective_radius * angle
        turned = (dx + 8.0 / P.rate_hz * wanted) / P.effective_radius if out[-1][1] else 0.0
        force += stiffness * (radius * turned - dx) - force * dx / sigma
        x, angle = x + dx, angle + turned
    by_force = [k for k, lead in enumerate(leads) if lead]
    known = next(k for k, (_, _, r) in enumerate(out) if r == r)
    assert out[by_force[0]][0] < 0.04 < out[known][0] < 0.052
    assert abs(out[known][1] - out[known - 1][1]) < 0.02 * abs(out[known][1])
    assert c.tire.stiffness == pytest.approx(stiffness, rel=0.02)
    assert c.tire.relaxation == pytest.approx(sigma, rel=0.1)
    assert c.tire.effective_radius == pytest.approx(radius, rel=0.002)
    assert c.gains == design_gains(c.tire.stiffness, c.tire.relaxation, P.loop_delay)


@pytest.mark.parametrize(("settled_time", "cycles"), [(0.4, 100), (0.403, 101)])
def test_settled_takes_the_whole_time_after_every_absence_from_the_band(settled_time, cycles):
    c = FreeRollingController(replace(P, settled_filter=0.01, settled_time=settled_time))

    def until_settled(start: int) -> int:
        for n in range(start, start + 1000):
            c.step(*samples(n, 50.0))
            if c.state.settled:
                return n - start
        raise AssertionError("not settled")

    # from -150 N, with a filter of 2.5 cycles, to 2.5 N
    fall = math.ceil(P.rate_hz * 0.01 * math.log(150.0 / 2.5))
    for begin in (0, 2000):
        for n in range(begin, begin + 100):
            c.step(*samples(n, 200.0))
        assert not c.state.settled
        # the first cycle in the band counts, and more than `cycles` are needed
        assert until_settled(begin + 100) == fall - 1 + cycles


def test_the_travel_goes_on_when_the_trigger_sets_the_position_to_zero():
    start = Start(P)
    _, encoders = samples(0, 0.0)
    start.observe(0.0, encoders)
    assert start.observe(0.0, encoders._replace(plank_position=0.1002)) == pytest.approx(2e-4)
    jumped = encoders._replace(plank_position=0.0)
    assert start.observe(0.0, jumped) == pytest.approx(2e-4 + 0.03092 / P.rate_hz)


def test_the_delay_of_the_loop_has_the_hold_of_half_a_cycle():
    assert P.loop_delay == pytest.approx((2.0 + 0.5) / 250.0)


def test_a_wheel_without_a_tire_on_the_road_starts_after_4_mm():
    """No force tells its stiffness; the servo makes up the travel that was lost."""
    start, step = Start(P), 0.03092 / P.rate_hz
    torques = [start.step(*held_tire(n, step * n, stiffness=1000.0)) for n in range(60)]
    waiting = torques.index(next(t for t in torques if t != 0.0))
    assert waiting == math.ceil(0.004 / step + 1e-9)
    assert math.isnan(start.stiffness)
    assert all(0.0 < t <= P.torque_max for t in torques[waiting:])


def test_the_servo_gives_up_after_5_cm_of_road():
    start, step = Start(P), 0.03092 / P.rate_hz
    n = 0
    while start.phase != OVER:
        start.step(*held_tire(n, step * n))
        n += 1
    assert start.travel == pytest.approx(0.05, abs=step)


def test_the_servo_ends_a_quarter_of_a_second_after_it_has_caught_up():
    start, step = Start(P), 0.03092 / P.rate_hz
    n = 0
    while start.phase != CATCH_UP:
        start.step(*held_tire(n, step * n))
        n += 1
    begun, turned = n, 0.0
    while start.phase != OVER:
        # the wheel is where it would be without loss, and stretches the tire to the reference
        force, encoders = held_tire(n, step * n)
        turned = (step * n + P.reference / start.stiffness) / P.effective_radius
        start.step(force, encoders._replace(wheel_angle=encoders.wheel_angle + turned))
        n += 1
    assert (n - begun + 1) / P.rate_hz == pytest.approx(0.25, abs=2.0 / P.rate_hz)


@pytest.mark.parametrize(
    ("ahead", "velocity", "motor"),
    [
        (0.0002, 0.03, 100.0),  # behind by 0.2 mm
        (-0.0005, 0.03, 100.0),  # ahead of the road
        (-0.05, 0.03, 1.0),  # so far ahead that the wheel waits
        (0.05, 0.03, 200.0),  # so far behind that the fastest wheel is asked for
        (0.05, 0.0, 1.0),  # before the velocity of the plank is known
    ],
)
def test_the_servo_asks_for_the_road_and_the_lost_travel(ahead, velocity, motor):
    """Motor speed and torque by hand; the wheel also stretches the tire to the reference. The
    torque that the force loop takes over follows within 50 ms."""
    p = replace(P, torque_min=-100.0, torque_max=100.0, catch_gain=0.01)
    start, stiffness = Start(p), 4e5
    torques, x = [start.step(*held_tire(0, 0.0, stiffness))], 0.0
    while start.phase != CATCH_UP:
        x += 0.03092 / p.rate_hz
        torques.append(start.step(*held_tire(0, x, stiffness)))
    force, encoders = held_tire(0, x, stiffness)
    turned = (x + p.reference / stiffness - ahead) / p.effective_radius
    encoders = encoders._replace(wheel_angle=turned, motor_velocity=motor, plank_velocity=velocity)
    gear = p.gear_ratio / p.effective_radius
    wanted = min(max(gear * (velocity + 8.0 * ahead), 0.0), 1.5 * gear * max(velocity, 0.01))
    for _ in range(5):
        torques.append(start.step(force, encoders))
        assert torques[-1] == pytest.approx(p.start_torque + 0.01 * (wanted - motor), rel=1e-4)
    smooth = 0.0
    for torque in filter(None, torques):
        smooth += -math.expm1(-1.0 / (0.05 * p.rate_hz)) * (torque - smooth)
    assert start.torque == pytest.approx(smooth)


@pytest.mark.parametrize(("motor", "limit"), [(-1e4, P.torque_max), (1e4, P.torque_min)])
def test_the_torque_of_the_servo_stays_within_the_limits(motor, limit):
    start, step = Start(P), 0.03092 / P.rate_hz
    n = 0
    while start.phase != CATCH_UP:
        start.step(*held_tire(n, step * n))
        n += 1
    held, encoders = held_tire(n, step * n)
    assert start.step(held, encoders._replace(motor_velocity=motor)) == limit


def transient(stiffness: float, sigma: float, radius: float, count: int = 400):
    """Travel, angle and force of a rolling tire: dF/dx = C_x (r dtheta/dx - 1) - F / sigma."""
    x, dx, force, out = 0.0, 1e-4, 0.0, []
    for k in range(count):
        angle = (x + 0.002 * math.sin(0.05 * k)) / 0.3
        out.append((x, angle, force))
        more = (x + dx + 0.002 * math.sin(0.05 * (k + 1))) / 0.3 - angle
        # the trapezoid of the estimator, solved for the new force
        grown = force + stiffness * (radius * more - dx) - 0.5 * dx * force / sigma
        force, x = grown / (1.0 + 0.5 * dx / sigma), x + dx
    return out


@pytest.mark.parametrize(
    ("sigma", "known"), [(0.3, True), (1.5, True), (0.03, False), (3.0, False)]
)
def test_the_estimate_is_the_tire_that_made_the_forces(sigma, known):
    estimator = StiffnessEstimator(0.3085)
    for sample in transient(3e5, sigma, 0.305):
        estimator.add(*sample)
    tire = estimator.solve()
    assert tire.stiffness == pytest.approx(3e5, rel=1e-4)
    assert tire.effective_radius == pytest.approx(0.305, rel=1e-5)
    if known:
        assert tire.relaxation == pytest.approx(sigma, rel=1e-3)
    else:
        assert math.isnan(tire.relaxation), "no tire has it"


@pytest.mark.parametrize("count", [0, 1, 8])
def test_few_samples_are_no_estimate(count):
    estimator = StiffnessEstimator(0.3085)
    for sample in transient(3e5, 0.3, 0.305)[:count]:
        estimator.add(*sample)
    assert all(math.isnan(value) for value in estimator.solve())


def test_forces_of_noise_are_no_estimate():
    estimator, draw = StiffnessEstimator(0.3085), random.Random(1)
    for x, angle, _ in transient(3e5, 0.3, 0.305):
        estimator.add(x, angle, draw.gauss(0.0, 100.0))
    assert all(math.isnan(value) for value in estimator.solve())


def test_an_estimate_is_known_when_its_standard_error_is_a_fifth_at_most():
    """Against least squares of numpy, for noise of 1 N to 30 kN."""
    outcomes = set()
    for size in np.geomspace(1.0, 3e4, 25):
        estimator, noise = StiffnessEstimator(0.3085), random.Random(3)
        rows = [(x, a, f + noise.gauss(0.0, size)) for x, a, f in transient(3e5, 0.3, 0.305)]
        for row in rows:
            estimator.add(*row)
        x, angle, force = np.array(rows).T
        integral = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))])
        columns = np.stack([0.3085 * angle - x, x, integral, np.ones_like(x)], 1)
        p, rest, *_ = np.linalg.lstsq(columns, force, rcond=None)
        variance = float(rest[0]) / (len(rows) - 4)
        error = math.sqrt(variance * np.linalg.inv(columns.T @ columns)[0, 0])
        stiffness = p[0] - p[1]
        known = stiffness > 0.0 and error < 0.2 * stiffness
        outcomes.add(known)
        tire = estimator.solve()
        assert (not math.isnan(tire.stiffness)) is bool(known)
        if known:
            assert tire.stiffness == pytest.approx(stiffness, rel=1e-4)
    assert outcomes == {True, False}


def test_a_very_soft_tire_is_known_too():
    estimator = StiffnessEstimator(0.3085)
    for sample in transient(2e3, 0.3, 0.305):
        estimator.add(*sample)
    assert estimator.solve().stiffness == pytest.approx(2e3, rel=1e-4)


def stiffness_of(forces: list[float], travels: list[float]) -> tuple[Start, int]:
    """A start after its first phase, and the number of samples that this took."""
    start = Start(P)
    for n, (force, x) in enumerate(zip(forces, travels, strict=True)):
        _, encoders = held_tire(n, x)
        start.step(force, encoders)
        if start.phase == CATCH_UP:
            return start, n + 1
    return start, len(forces)


def test_the_stiffness_is_the_slope_of_the_forces_that_are_noticed():
    """Forces below 25 N are the play of the gear; the line need not go through zero."""
    travels = [1.2e-4 * k for k in range(30)]
    forces = [0.0 if x < 5e-4 else -30.0 - 2e5 * (x - 5e-4) for x in travels]
    start, used = stiffness_of(forces, travels)
    assert start.stiffness == pytest.approx(2e5, rel=1e-9)
    # by hand: first noticed at 6e-4 m, 1.2 mm of travel later it is enough
    assert travels[used - 1] == pytest.approx(6e-4 + 1.32e-3)


@pytest.mark.parametrize(("slope", "samples"), [(4e6, 5), (4e5, 10)])
def test_a_large_force_ends_the_estimate_but_not_before_five_samples(slope, samples):
    travels = [1.2e-4 * k for k in range(30)]
    start, used = stiffness_of([-slope * x for x in travels], travels)
    assert start.stiffness == pytest.approx(slope, rel=1e-9)
    # the first of them is at zero force and does not count; 450 N of 4e5 N/m are 1.125 mm
    assert used == 1 + max(5, samples)


def test_a_road_that_stands_gives_no_stiffness():
    start, used = stiffness_of([0.0, *[-500.0] * 10], [0.0, *[1e-4] * 10])
    assert used == 6 and start.phase != MEASURE_STIFFNESS
    assert math.isnan(start.stiffness)
