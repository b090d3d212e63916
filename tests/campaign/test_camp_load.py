# SPDX-License-Identifier: Apache-2.0
"""Load and steering are held on driven axes of the simulated bench; profiles of the other axes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.steering_hold import PROFILES, HoldParameters, SteeringHold
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_validation.bench.start_bench import StartBench

DEFECTS = {
    "support_bearings": {"positions": [0.6, 1.0, 1.4], "heights": [1.2e-4, -1.5e-4, 2.0e-4]},
    "load_change": {"brake": 0.0097, "drive": 0.0040},
}
RULES = ("inputs", "drive_fault", "emergency_stop", "speed")
FZ = 3700.0


class LoadBench(StartBench):
    """With a driven vertical axis under the load controller."""

    def __init__(self, **load) -> None:
        super().__init__(
            "toyo", overrides={"driven_axes": ["wheel", "vertical"], "defects": DEFECTS}
        )
        self.load = LoadController(LoadParameters(vertical_stiffness=2.13e5, **load))
        self.axis = AxisDrive(
            DriveParameters(
                axis="vertical", gear_ratio=1.0, output_per_turn=0.0002, unit="m",
                speed_limit=0.006, speed_trip=0.02, move_speed=0.005, rules=RULES,
            )
        )  # fmt: skip
        self.steered = False

    def cycle(self) -> None:
        inputs = self.plant.step(self._commands)
        hub, encoders = self.hub.step(inputs), self.encoders.step(inputs)
        self.hub_sample, self.encoder_sample = hub, encoders
        listens = self.drive.reference_source == "slip"
        reference = self.sequencer.step(encoders) if listens else None
        command, self.sample = self.drive.step(inputs, encoders, hub, reference)
        if self.steered:
            self.axis.set_operation_mode("velocity", self.load.step(hub))
        other, self.axis_sample = self.axis.step(inputs, None, None, None)
        self._commands = (command, other)

    def hold(self, fz: float) -> None:
        """From now on the controller has the axle."""
        self.axis.set_operation_mode("velocity", 0.0)
        self.cycle()
        assert self.axis.enable().accepted
        self.until(lambda: self.axis_sample.state == 4, 2.0)
        self.load.set_load(fz)
        self.steered = True


def braking(enabled: bool) -> np.ndarray:
    """Fz over the road in a run at -10 % from 0.3 m on."""
    bench = LoadBench(enabled=enabled)
    bench.sequencer.set_slip_step(-0.1, 0.3, 0.3109)
    bench.ready(FZ, "slip")
    bench.hold(FZ)
    bench.plant.operator.plank(1, fast=True)
    rows = []
    while not rows or rows[-1][0] < 1.6:
        bench.cycle()
        rows.append((bench.plant.truth.plank_position, bench.plant.truth.fz))
    return np.array(rows)


def test_the_load_is_held_through_undulation_and_braking(capsys):
    free, held = (np.abs(braking(on)[:, 1] / FZ - 1.0).max() for on in (False, True))
    with capsys.disabled():
        print(f"\nFz at -10 % over bearings: {100 * free:.2f} % off, {100 * held:.2f} % when held")
    assert held < 0.01 < free


def test_a_new_set_point_is_reached_without_overshoot():
    bench = LoadBench(enabled=True)
    bench.plant.operator.load_to(2000.0)
    bench.until(lambda: bench.plant.operator.view.load_reached)
    bench.hold(FZ)
    fz = []
    for _ in range(1500):
        bench.cycle()
        fz.append(bench.plant.truth.fz)
    assert max(fz) < 1.02 * FZ
    assert fz[-1] == pytest.approx(FZ, rel=0.002)


@pytest.mark.parametrize("fz", [8001.0, -1.0, math.nan, math.inf])
def test_an_impossible_load_is_refused(fz):
    controller = LoadController(LoadParameters())
    words = f"fz is {fz:g}(, must be finite| N, must be within 0 .. 8000)"
    with pytest.raises(ValueError, match=words):
        controller.set_load(fz)
    controller.set_load(8000.0)


def test_the_steering_is_held_against_its_play():
    """The tire pulls the hub through 0.2 deg of play; the motor follows until the hub is back."""
    hold = SteeringHold(HoldParameters(enabled=True))
    motor, play = 0.0, math.radians(0.2)
    for _ in range(2500):
        motor += hold.step(0.0, motor + play) / 250.0
    assert abs(motor + play) < math.radians(0.03)
    assert SteeringHold(HoldParameters(enabled=False)).step(0.0, 0.1) == 0.0


@pytest.mark.parametrize("name", PROFILES)
def test_profiles_stay_within_their_amplitude_and_do_not_jump(name):
    profile = PROFILES[name](amplitude=0.1)
    t = np.arange(0.0, 60.0, 0.01)
    angle = np.array([profile.angle(float(v)) for v in t])
    assert np.abs(angle).max() == pytest.approx(0.1, rel=0.02)
    assert np.abs(np.diff(angle)).max() < 0.01
    assert abs(angle[0]) < 1e-9
