# SPDX-License-Identifier: Apache-2.0
"""The loop closed over the simulated bench: free rolling, effective rolling radius, slip steps,
stops."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from loop_bench import GEAR, LoopBench

from flatplank_hw.drive import REASONS
from flatplank_hw.drive.safety import RULES
from flatplank_validation.free_rolling.nonlinear import settling_distance

LOADS = (1000.0, 1850.0, 3700.0, 5550.0, 8000.0)
POSITION, VELOCITY, FX, TRUE_FX, TRUE_RE, WHEEL, MOTOR = range(7)
STEADY = (1.6, 4.1)
STOP_TIME = 0.1
"""[s]"""
GEAR_GAP = math.radians(30.0) / GEAR
"""The pull of the tire may rock a wheel whose motor stands within the gap of its gears [rad]."""


@cache
def free_rolling(fz: float, tire: str = "toyo") -> np.ndarray:
    bench = LoopBench(tire)
    bench.load(fz)
    bench.enable("free_rolling")
    rows = bench.travel(4.12)
    assert bench.drive_sample.stop_reason == 0
    return rows


@cache
def slip_stiffness(fz: float) -> float:
    """C_Fk [N] of the plant near free rolling: Fx over slip from a run at +0.2 %."""
    bench = LoopBench()
    bench.load(fz)
    radius = free_rolling(fz)[-1, TRUE_RE]
    assert bench.sequencer.set_waveform("constant", {"kappa": 0.002}, 0.0, radius).accepted
    bench.enable("slip")
    rows = bench.travel(3.0)
    late = rows[rows[:, POSITION] > 2.5]
    slip = radius * late[:, MOTOR].mean() / GEAR / late[:, VELOCITY].mean() - 1.0
    return float(late[:, FX].mean() / slip)


def between(rows: np.ndarray, low: float, high: float) -> np.ndarray:
    return rows[(rows[:, POSITION] > low) & (rows[:, POSITION] < high)]


@pytest.mark.parametrize("fz", LOADS)
def test_steady_force_is_within_one_percent(fz, capsys):
    """Mean of the last 1.5 m, as thesis 5.6."""
    rows = free_rolling(fz)
    error = between(rows, 2.6, 4.1)[:, FX].mean() / 50.0 - 1.0
    settled = settling_distance(rows[:, POSITION], rows[:, FX])
    with capsys.disabled():
        print(
            f"\nToyo {fz:.0f} N: steady error {100 * error:+.3f} %, settled after {settled:.3f} m"
        )
    assert abs(error) < 0.01
    assert settled <= 1.6


@pytest.mark.parametrize(("tire", "fz"), [("michelin", 2400.0), ("continental", 3250.0)])
def test_other_tires(tire, fz):
    rows = free_rolling(fz, tire)
    assert abs(between(rows, 2.6, 4.1)[:, FX].mean() / 50.0 - 1.0) < 0.015
    assert settling_distance(rows[:, POSITION], rows[:, FX]) <= 1.6


@pytest.mark.parametrize("fz", [1850.0, 3700.0, 5550.0])
def test_effective_rolling_radius(fz, capsys):
    """(5.22), corrected by 50 N / C_Fk, against the plant's own and against the flexplates-off
    run."""
    steady = between(free_rolling(fz), *STEADY)
    raw = GEAR * steady[:, VELOCITY].mean() / steady[:, MOTOR].mean()
    found = raw * (1.0 + 50.0 / slip_stiffness(fz))
    true = steady[:, TRUE_RE].mean()
    bench = LoopBench()
    bench.load(fz)
    bench.plant.operator.flexplates(False)
    loose = between(bench.travel(4.12), *STEADY)
    free = loose[:, VELOCITY].mean() / loose[:, WHEEL].mean()
    with capsys.disabled():
        print(
            f"\nToyo {fz:.0f} N: r_e {found:.5f} m (uncorrected {raw:.5f}), plant {true:.5f}, "
            f"flexplates off {free:.5f} at Fx {loose[:, TRUE_FX].mean():.0f} N"
        )
    assert found == pytest.approx(true, rel=0.003)
    assert found == pytest.approx(free, rel=0.003)


@pytest.mark.parametrize("kappa", [-0.05, 0.02])
def test_slip_step(kappa):
    bench = LoopBench()
    bench.load(3700.0)
    radius = 0.3109
    assert bench.sequencer.set_slip_step(kappa, 1.2, radius).accepted
    bench.enable("slip")
    rows = bench.travel(3.0)
    before, after = between(rows, 1.1, 1.18), between(rows, 2.5, 3.0)
    slip = radius * after[:, MOTOR].mean() / GEAR / after[:, VELOCITY].mean() - 1.0
    assert slip == pytest.approx(kappa, abs=2e-4)
    assert bench.sequencer.state.reference_slip == kappa
    assert abs(before[:, FX].mean()) < 120.0
    assert after[:, FX].mean() * np.sign(kappa) > 1200.0
    assert bench.drive_sample.stop_reason == 0


def running(mode: str) -> LoopBench:
    bench = LoopBench()
    bench.load(3700.0)
    assert bench.sequencer.set_slip_step(0.05, 1.0, 0.3109).accepted
    bench.enable(mode)
    bench.travel(0.3)
    return bench


def silent(bench: LoopBench, name: str) -> None:
    """A node dies: what it said last stays, or nothing comes any more."""
    core = getattr(bench, name)
    last = bench.encoder_sample if name == "encoders" else bench.hub_sample
    frozen = last if name in ("encoders", "hub") else None
    core.step = lambda *_: frozen


CAUSES = {
    "emergency_stop": lambda bench: bench.plant.operator.emergency_stop(True),
    "samples": lambda bench: silent(bench, "encoders"),
    "samples-hub": lambda bench: silent(bench, "hub"),
    "reference": lambda bench: silent(bench, "sequencer") or silent(bench, "controller"),
    "steering": lambda bench: setattr(
        bench.encoders, "_steer_offset", bench.encoders._steer_offset + 1.0
    ),
    "drive_fault": lambda bench: bench.plant.inject_fault("wheel"),
}


def assert_stands(bench: LoopBench) -> None:
    """From `STOP_TIME` on the shaft at the plant does not turn any more."""
    bench.run(STOP_TIME)
    angle = bench.plant.truth.wheel_angle
    for _ in range(100):
        bench.cycle()
        truth = bench.plant.truth
        assert abs(truth.wheel_angle - angle) <= GEAR_GAP
        assert abs(truth.motor_velocity) / GEAR < 1e-4


@pytest.mark.parametrize("mode", ["slip", "free_rolling"])
@pytest.mark.parametrize("name", CAUSES)
def test_the_wheel_stands_within_100_ms(name, mode):
    """Counted from the cause."""
    bench = running(mode)
    CAUSES[name](bench)
    assert_stands(bench)
    assert bench.drive_sample.stop_reason == RULES[name.removesuffix("-hub")].code
    assert bench.drive_sample.state != 4


@pytest.mark.parametrize("mode", ["slip", "free_rolling"])
def test_the_wheel_stands_100_ms_after_the_plank(mode):
    bench = running(mode)
    bench.plant.operator.plank(0)
    bench.run(1.0, until=lambda: bench.plant.truth.road_velocity == 0.0)
    assert_stands(bench)
    assert REASONS[bench.drive_sample.stop_reason] == RULES["plank_stopped"].text


def test_slip_control_at_the_slow_speed_of_the_plank_is_given_up():
    bench = LoopBench()
    bench.load(3700.0)
    assert bench.sequencer.set_slip_step(0.05, 1.0, 0.3109).accepted
    bench.enable("slip")
    bench.plant.operator.plank(1, fast=False)
    bench.run(1.0)
    assert bench.drive_sample.stop_reason == RULES["reference"].code
    assert abs(bench.plant.truth.motor_velocity) / GEAR < 1e-4


def test_the_next_measurement_works_after_a_stop():
    """Unload, return the plank, turn the wheel, reload, run: the operator's sequence."""
    bench = running("slip")
    operator = bench.plant.operator
    operator.emergency_stop(True)
    bench.run(1.0)
    assert not bench.drive.enable().accepted
    operator.emergency_stop(False)
    operator.unload()
    bench.run(20.0, until=lambda: operator.view.at_target)
    operator.plank(-1, fast=True, stop_at=0.0)
    bench.run(60.0, until=lambda: operator.view.plank_position < 1e-3)
    bench.run(1.0)
    assert bench.drive.set_operation_mode("position").accepted
    assert bench.drive.enable().accepted
    bench.run(1.0, until=lambda: bench.drive_sample.state == 4)
    target = 2.0943951
    assert bench.drive.move_to(target).accepted
    bench.run(60.0, until=lambda: bench.drive.at_target)
    bench.run(0.5)
    assert bench.drive_sample.position == pytest.approx(target, abs=1e-4)
    assert bench.encoder_sample.mismatch == pytest.approx(0.0, abs=1e-3)
    bench.load(3700.0)
    bench.encoders.arm()
    bench.sequencer.reset()
    assert bench.sequencer.set_slip_step(0.05, 0.5, 0.3109).accepted
    assert bench.drive.set_operation_mode("slip").accepted
    rows = bench.travel(1.5)
    assert rows[-1, FX] > 2000.0
    assert 0.0 < bench.encoder_sample.plank_position < rows[-1, POSITION]


def test_homing_on_the_plant():
    bench = LoopBench()
    bench.run(0.5)
    assert bench.drive.enable().accepted
    bench.run(1.0, until=lambda: bench.drive_sample.state == 4)
    bench.drive.move_to(0.5)
    bench.run(30.0, until=lambda: bench.drive.at_target)
    bench.run(0.5)
    before = bench.encoder_sample
    assert bench.drive.home().accepted
    bench.run(1.0, until=lambda: bench.drive.mode == "position")
    assert bench.drive_sample.position == pytest.approx(0.0, abs=1e-4)
    bench.run(0.5)
    assert bench.encoder_sample.motor_angle == pytest.approx(before.motor_angle, abs=0.05)
    assert bench.drive.move_to(-0.2).accepted
    bench.run(30.0, until=lambda: bench.drive.at_target)
    bench.run(0.5)
    assert bench.drive_sample.position == pytest.approx(-0.2, abs=1e-4)
