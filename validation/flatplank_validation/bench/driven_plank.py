# SPDX-License-Identifier: Apache-2.0
"""Start with driven plank and wheel, without plans: the plank's drive ramps up, and the wheel
follows the plank's encoder from its first counts on."""

from __future__ import annotations

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.moves import SPEED
from flatplank_hw.bus.image import BusInputs
from flatplank_hw.cia402 import State
from flatplank_hw.samples import EncoderSample, HubSample
from flatplank_sim.twin.twin import make_axis
from flatplank_validation.bench.start_bench import StartBench


class DrivenPlank(StartBench):
    """Bench whose plank has a drive instead of the switch."""

    def __init__(self, tire: str = "toyo", **options) -> None:
        super().__init__(tire, overrides={"driven_axes": ["wheel", "plank"]}, **options)
        self.plank = make_axis(BenchSetup(axes=("plank",)), "plank").drive

    def more(self, inputs: BusInputs, encoders: EncoderSample, hub: HubSample) -> tuple:
        command, self.plank_sample = self.plank.step(inputs, encoders, hub, None)
        return (command,)

    def move_plank(self) -> None:
        self.plank.set_operation_mode("velocity", 0.0)
        self.plank.enable()
        self.until(lambda: self.plank_sample.state == State.OPERATION_ENABLED, 2.0)
        self.plank.set_operation_mode("velocity", SPEED)
