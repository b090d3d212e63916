# SPDX-License-Identifier: Apache-2.0
"""Encoders: positions, velocities, trigger, motion of the plank, lost cycles, motor against
wheel."""

from __future__ import annotations

import math
import time

import pytest

from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs, Digital
from flatplank_hw.encoders import EncoderParameters, Encoders

OK = int(Digital.EMERGENCY_STOP_OK)
TRIGGER = OK | int(Digital.TRIGGER)
P = EncoderParameters()
COUNT = 2 * math.pi * P.pinion_pitch_radius / P.plank_counts_per_turn
MOTOR = 2**23 * P.gear_ratio / (2 * math.pi)


def wrap(counts: int) -> int:
    """As the int32 on the bus."""
    return (counts + 2**31) % 2**32 - 2**31


def image(n, plank=0, wheel=0, motor=0, period_ns=4_000_000, mode=9, **fields) -> BusInputs:
    """Cycle n with unwrapped counts."""
    axis = AxisInputs(0x27, mode, wrap(motor), 0, 0, 0)
    rest = AxisInputs(0x27, 0, 0, 0, 0, 0)
    values = {
        "bridge_volts": (0.0,) * 6,
        "lvdt_volts": 0.0,
        "plank_counts": wrap(plank),
        "wheel_counts": wrap(wheel),
        "steer_counts": 0,
        "camber_counts": 0,
        "road_counts": 0,
        "digital": OK,
        "health": 0,
        "axes": (axis,) + (rest,) * (len(AXES) - 1),
    }
    return BusInputs(cycle=n, stamp_ns=n * period_ns, **{**values, **fields})


def plank_counts(t: float, speed: float) -> int:
    return math.floor(speed * t / COUNT)


def test_positions_velocities_and_angles():
    e = Encoders(P)
    for n in range(200):
        t = n * 0.004
        sample = e.step(
            image(
                n,
                plank=plank_counts(t, 0.03092),
                wheel=math.floor(0.1 * t / (2 * math.pi) * 20000),
                motor=math.floor(0.1 * t * MOTOR),
                steer_counts=100,
                camber_counts=-50,
            )
        )
    assert sample.plank_position == pytest.approx(0.03092 * t, abs=COUNT)
    assert sample.plank_velocity == pytest.approx(0.03092, rel=0.005)
    assert sample.wheel_angle == pytest.approx(0.1 * t, abs=2 * math.pi / 20000)
    assert sample.wheel_velocity == pytest.approx(0.1, rel=0.02)
    assert sample.motor_angle == pytest.approx(0.1 * t * P.gear_ratio, abs=1e-5)
    assert sample.motor_velocity == pytest.approx(0.1 * P.gear_ratio, rel=1e-6)
    assert sample.steer_angle == pytest.approx(100 * 2 * math.pi / 20000)
    assert sample.road_camber == pytest.approx(-50 * 2 * math.pi / 20000)
    assert math.isnan(sample.road_position)
    assert abs(sample.mismatch) < 2 * 2 * math.pi / 20000
    assert sample.plank_moving
    assert not sample.trigger


def test_offsets_and_turned_signs():
    e = Encoders(EncoderParameters(slip_angle_offset_deg=1.0, plank_counts_per_turn=-20000))
    e.step(image(0))
    sample = e.step(image(1, plank=-100))
    assert sample.plank_position == pytest.approx(100 * COUNT)
    assert sample.steer_angle == pytest.approx(math.radians(1.0))


def test_second_road_encoder():
    p = EncoderParameters(road_encoder_fitted=True)
    e = Encoders(p)
    e.step(image(0))
    for n in range(1, 30):
        digital = TRIGGER if n >= 10 else OK
        sample = e.step(image(n, plank=8 * n, road_counts=16 * n, digital=digital))
    assert sample.road_position == pytest.approx(
        16 * 19 * 2 * math.pi * p.road_encoder_radius / 20000
    )
    assert sample.plank_position == pytest.approx(8 * 19 * COUNT)


def test_trigger_zeroes_once_until_armed_again():
    e = Encoders(P)
    n = 0

    def go(steps, per_cycle, digital=OK):
        nonlocal n, counts
        for _ in range(steps):
            counts += per_cycle
            sample = e.step(image(n, plank=counts, digital=digital))
            n += 1
        return sample

    counts = 1000
    go(30, 8)
    assert go(1, 8, TRIGGER).plank_position == 0.0
    assert not e.armed
    assert go(20, 8).plank_position == pytest.approx(160 * COUNT)
    assert go(1, 8, TRIGGER).plank_position == pytest.approx(168 * COUNT)
    assert e.arm().cycle == n
    # on its way back the strip passes the sensor too: that is no start
    go(20, -7)
    assert go(1, -7, TRIGGER).plank_position == pytest.approx(21 * COUNT)
    assert e.armed
    go(20, -7)
    go(30, 8)
    assert go(1, 8, TRIGGER).plank_position == 0.0


def test_a_trigger_that_is_on_from_the_beginning_is_no_edge():
    e = Encoders(P)
    for n in range(20):
        sample = e.step(image(n, plank=8 * n, digital=TRIGGER))
    assert sample.plank_position == pytest.approx(8 * 19 * COUNT)
    assert sample.trigger


@pytest.mark.parametrize(("speed", "within"), [(0.0015, 0.045), (0.03092, 0.01), (-0.03092, 0.01)])
def test_start_and_stop_of_the_plank_are_seen_in_time(speed, within):
    e = Encoders(P)
    start, stop = 50, 400
    flags = []
    for n in range(600):
        t = (min(max(n, start), stop) - start) * 0.004
        flags.append(e.step(image(n, plank=plank_counts(t, speed))).plank_moving)
    first, last = flags.index(True), 599 - flags[::-1].index(True)
    assert 0 < (first - start) * 0.004 <= within
    assert 0 <= (last - stop) * 0.004 <= 0.044
    assert flags == [first <= n <= last for n in range(600)]


def test_a_flickering_count_is_no_motion():
    e = Encoders(P)
    flags = [e.step(image(n, plank=1234 + n % 2)).plank_moving for n in range(500)]
    assert not any(flags)


def test_lost_cycles_leave_the_velocities_true():
    e = Encoders(P)
    for n in [*range(100), 104, 105, 106, 111, *range(112, 130)]:
        sample = e.step(image(n, plank=16 * n, wheel=3 * n, motor=50_000 * n))
        if n > 30:
            assert sample.plank_velocity == pytest.approx(16 * 250 * COUNT, rel=0.002)
            assert sample.motor_velocity == pytest.approx(
                50_000 * 250 * 2 * math.pi / 2**23, rel=1e-9
            )


def test_a_long_gap_starts_from_rest():
    e = Encoders(P)
    for n in range(100):
        e.step(image(n, plank=16 * n))
    sample = e.step(image(5000, plank=16 * 5000))
    assert sample.plank_position == pytest.approx(16 * 5000 * COUNT)


@pytest.mark.parametrize("gap", [2, 50, 51, 1000])
def test_a_gap_of_50_cycles_is_bridged_and_a_longer_one_starts_from_rest(gap):
    e = Encoders(P)
    for n in [*range(100), 99 + gap]:
        sample = e.step(image(n, plank=16 * n, wheel=3 * n, motor=50_000 * n))
    speeds = (sample.plank_velocity, sample.wheel_velocity, sample.motor_velocity)
    true = (16 * 250 * COUNT, 3 * 250 * 2 * math.pi / 20000, 50_000 * 250 * 2 * math.pi / 2**23)
    if gap <= 50:
        assert speeds == pytest.approx(true, rel=1e-3)
    else:
        # one jump in a window: its slope, 6 (n - 1) / (n (n^2 - 1)) of it per sample
        windows = (25, 25, 5)
        jumps = [speed * gap * 6.0 / (n * (n + 1)) for speed, n in zip(true, windows, strict=True)]
        assert speeds == pytest.approx(jumps, rel=1e-6)
    assert sample.plank_position == pytest.approx(16 * (99 + gap) * COUNT)


@pytest.mark.parametrize("share", [0.01, 0.019])
def test_jitter_of_the_bus_does_not_change_a_velocity(share):
    """Its stamps are those of the computer; the counts are read in equal steps."""
    e = Encoders(P)
    for n in range(200):
        late = round(share * 0.5 * 4_000_000 * (n % 2))
        sample = e.step(image(n, plank=4 * n)._replace(stamp_ns=n * 4_000_000 + late))
        if n > 30:
            assert sample.plank_velocity == pytest.approx(4 * 250 * COUNT, rel=1e-9)


def test_an_encoder_that_counts_backward_has_the_same_trigger():
    """The strip passes the sensor forward, back, and forward again."""
    e = Encoders(EncoderParameters(plank_counts_per_turn=-P.plank_counts_per_turn))
    counts, zeros, n = 0, [], 0
    for speed in (8, -8, 8):
        e.arm()
        for k in range(60):
            counts -= speed
            sample = e.step(image(n, plank=counts, digital=TRIGGER if k >= 40 else OK))
            zeros.append(sample.plank_position == 0.0 and k == 40)
            n += 1
        for _ in range(5):
            e.step(image(n, plank=counts))
            n += 1
    assert [k for k, zero in enumerate(zeros) if zero] == [40, 160]


@pytest.mark.parametrize("counts", [2**31, -(2**31)])
def test_counts_of_a_turn_are_those_of_a_counter_of_32_bits(counts):
    assert EncoderParameters(wheel_counts_per_turn=counts).wheel_counts_per_turn == counts
    for bad in (0, counts + (1 if counts > 0 else -1)):
        with pytest.raises(ValueError, match="wheel_counts_per_turn"):
            EncoderParameters(wheel_counts_per_turn=bad)


def test_rate_of_the_bus_is_followed():
    e = Encoders(P)
    for n in range(200):
        sample = e.step(image(n, plank=4 * n, period_ns=1_000_000))
    assert sample.plank_velocity == pytest.approx(4 * 1000 * COUNT, rel=1e-9)


@pytest.mark.parametrize("first", [50, 55])
def test_homing_of_the_motor_is_no_motion(first):
    """The first cycle of homing that is seen: at 55 five were lost."""
    e = Encoders(P)
    for n in range(50):
        before = e.step(image(n, motor=3_000_000))
    for n in range(first, 60):
        sample = e.step(image(n, motor=0, mode=6))
        assert sample.motor_velocity == 0.0
    assert sample.motor_angle == before.motor_angle
    for n in range(60, 90):
        sample = e.step(image(n, motor=1000 * (n - 59)))
    assert sample.motor_angle - before.motor_angle == pytest.approx(30_000 * 2 * math.pi / 2**23)


def test_mismatch_is_counted_from_where_motor_and_wheel_stood():
    e = Encoders(P)
    stand = dict(motor=50_000_000, wheel=-3000)
    assert [e.step(image(n, **stand)).mismatch for n in range(3)] == [0.0] * 3
    # the wheel turns by a count, the motor stands
    turned = e.step(image(3, **stand | {"wheel": -2999})).mismatch
    assert turned == pytest.approx(-2 * math.pi / 20000)


def test_mismatch_shows_a_gear_that_slips():
    e = Encoders(P)
    for n in range(100):
        sample = e.step(image(n, motor=math.floor(0.0004 * n * MOTOR)))
    assert sample.mismatch == pytest.approx(0.0396, rel=1e-4)


def test_the_shortest_window_is_the_step_from_one_sample_to_the_next():
    p = EncoderParameters(wheel_velocity_window=0.005, motor_velocity_window=0.005)
    core = Encoders(p)
    for n, wheel in enumerate((0, 100, 300, 600)):
        sample = core.step(image(n, wheel=wheel, motor=wheel))
    assert sample.wheel_velocity == pytest.approx(
        2.0 * math.pi * 300 / p.wheel_counts_per_turn * p.rate_hz
    )
    assert sample.motor_velocity == pytest.approx(
        2.0 * math.pi * 300 / p.motor_counts_per_turn * p.rate_hz
    )


def test_a_cycle_is_cheap():
    e = Encoders(P)
    inputs = [image(n, plank=8 * n, wheel=n, motor=50_000 * n) for n in range(20000)]
    start = time.process_time()
    for i in inputs:
        e.step(i)
    # 3 us on the machine where it was written; the bound only catches a change of kind
    assert (time.process_time() - start) / len(inputs) < 25e-6
