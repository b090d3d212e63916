# SPDX-License-Identifier: Apache-2.0
"""A driven axis beside the wheel in the twin: its drive and its controller, as the graph has
them."""

from __future__ import annotations

from typing import Any

from flatplank_control.bench.node_specs import AXIS_NODES, DRIVEN
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.steering_hold import AngleControl, AngleParameters
from flatplank_data.params import Params, from_mapping
from flatplank_hw.bus.image import AxisCommand, BusInputs
from flatplank_hw.cia402 import State
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample

CONTROLLERS: dict[str, tuple[type, type[Params]]] = {
    "vertical": (LoadController, LoadParameters),
    "steer": (AngleControl, AngleParameters),
    "camber": (AngleControl, AngleParameters),
}


class TwinAxis:
    """Drive and controller of one axis; the plank's has none."""

    def __init__(self, drive: AxisDrive, controller: Any = None) -> None:
        self.drive, self.controller = drive, controller
        self.sample: DriveSample | None = None

    @property
    def enabled(self) -> bool:
        return self.sample is not None and self.sample.state == State.OPERATION_ENABLED

    def follow(self, on: bool) -> None:
        """The controller has the axis from now on, or lets go."""
        if on:
            self.controller.reset()
            self.drive.set_operation_mode("follow")
            self.drive.enable()
        else:
            self.drive.disable()

    def step(self, inputs: BusInputs, encoders: EncoderSample, hub: HubSample) -> AxisCommand:
        """One cycle."""
        reference = None
        if self.drive.listens_to == "follow":
            reference = self.controller.reference(hub, encoders)
        command, self.sample = self.drive.step(inputs, encoders, hub, reference)
        return command


def make_axis(setup: BenchSetup, axis: str) -> TwinAxis:
    """The axis as its parameter files say."""
    drive = from_mapping(DriveParameters, setup.of(DRIVEN[axis][0]), f"{axis}_drive")
    if axis not in CONTROLLERS:
        return TwinAxis(AxisDrive(drive))
    core, parameters = CONTROLLERS[axis]
    own = from_mapping(parameters, setup.of(AXIS_NODES[axis].controller), f"{axis} controller")
    return TwinAxis(AxisDrive(drive), core(own))
