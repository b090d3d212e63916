# SPDX-License-Identifier: Apache-2.0
"""The start with plank and wheel both driven: the drives begin in the same cycles."""

from __future__ import annotations

import numpy as np

from flatplank_control.bench.start_bench import StartBench
from flatplank_hw.bus.image import BusInputs
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.drive.cia402 import State
from flatplank_hw.samples import EncoderSample, HubSample

SPEED = 0.03092
RULES = ("inputs", "drive_fault", "emergency_stop", "speed")


class DrivenPlank(StartBench):
    """The plank's axis has a drive instead of the switch."""

    def __init__(self, tire: str = "toyo", **options) -> None:
        super().__init__(tire, overrides={"driven_axes": ["wheel", "plank"]}, **options)
        self.plank = AxisDrive(
            DriveParameters(
                axis="plank", gear_ratio=1.0, output_per_turn=0.0005, unit="m", speed_limit=0.04,
                speed_trip=0.05, move_speed=0.03, acceleration=0.206, standstill_speed=0.0005,
                rules=RULES,
            )
        )  # fmt: skip

    def more(self, inputs: BusInputs, encoders: EncoderSample, hub: HubSample) -> tuple:
        command, self.plank_sample = self.plank.step(inputs, encoders, hub, None)
        return (command,)

    def travel(self, distance: float) -> np.ndarray:
        """Plank forward over so many metres; a row per cycle."""
        self.plank.set_operation_mode("velocity", 0.0)
        self.plank.enable()
        self.until(lambda: self.plank_sample.state == State.OPERATION_ENABLED, 2.0)
        self.plank.set_operation_mode("velocity", SPEED)
        rows: list[tuple[float, ...]] = []
        while not rows or rows[-1][0] < distance:
            self.cycle()
            t = self.plant.truth
            rows.append((t.plank_position, t.fx, t.kappa, t.road_velocity))
        return np.array(rows)
