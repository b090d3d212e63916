# SPDX-License-Identifier: Apache-2.0
"""The bench in one process without ROS: the same cores in the same order as on the ROS graph, with
bit-identical results.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flatplank_control.bench.setup import AXIS_NODES, DRIVEN, BenchSetup
from flatplank_control.free_rolling import FreeRollingController, FreeRollingParameters
from flatplank_control.load_control import LoadController, LoadParameters
from flatplank_control.sequencer import SequencerParameters, SlipSequencer
from flatplank_control.steering_hold import AngleControl, AngleParameters
from flatplank_data.params import Params, from_mapping, to_mapping
from flatplank_hw.bus.image import AXES, AxisCommand, BusInputs
from flatplank_hw.cia402 import State, in_operation
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.encoders import EncoderParameters, Encoders
from flatplank_hw.hub import HubParameters, MeasurementHub
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Reference
from flatplank_sim.plant import Plant, PlantConfig

WHEEL = AXES.index("wheel")

CONTROLLERS: dict[str, tuple[type, type[Params]]] = {
    "vertical": (LoadController, LoadParameters),
    "steer": (AngleControl, AngleParameters),
    "camber": (AngleControl, AngleParameters),
}


class TwinAxis:
    """Drive and controller of one axis; the plank has no controller."""

    def __init__(self, drive: AxisDrive, controller: Any = None) -> None:
        self.drive, self.controller = drive, controller
        self.sample: DriveSample | None = None

    @property
    def enabled(self) -> bool:
        return self.sample is not None and self.sample.state == State.OPERATION_ENABLED

    def follow(self, on: bool) -> None:
        """Switch the controller of the axis on or off."""
        if on:
            self.controller.reset()
            self.drive.set_operation_mode("follow")
            self.drive.enable()
        else:
            self.drive.disable()

    def step(self, inputs: BusInputs, encoders: EncoderSample, hub: HubSample) -> AxisCommand:
        """Return the command of one cycle."""
        reference = None
        if self.drive.reference_source == "follow":
            reference = self.controller.reference(hub, encoders)
        command, self.sample = self.drive.step(inputs, encoders, hub, reference)
        return command


def make_axis(setup: BenchSetup, axis: str) -> TwinAxis:
    """Make an axis from its parameter files."""
    drive = from_mapping(DriveParameters, setup.of(DRIVEN[axis][0]), f"{axis}_drive")
    if axis not in CONTROLLERS:
        return TwinAxis(AxisDrive(drive))
    core, parameters = CONTROLLERS[axis]
    own = from_mapping(parameters, setup.of(AXIS_NODES[axis].controller), f"{axis} controller")
    return TwinAxis(AxisDrive(drive), core(own))


class Cycle(NamedTuple):
    """Samples of one cycle or batch, in the order of the topics."""

    batch: tuple[BusInputs, ...]
    hub: HubSample
    encoders: EncoderSample
    reference: Reference | None
    inside: Any
    """internal state of the source that made the reference"""
    command: AxisCommand
    drive: DriveSample


class Twin:
    """Plant, hub, encoders, sources and drives, stepped like the ROS graph in lockstep."""

    def __init__(self, setup: BenchSetup) -> None:
        def make(cls: type, name: str) -> Any:
            node = next(n for n in setup.nodes() if n.name == name)
            return from_mapping(cls, setup.of(node), name)

        bus = setup.of(setup.nodes()[-1])
        config = PlantConfig.load(
            bus["tire"],
            preset=bus["preset"] or None,
            file=bus["config"] or None,
            overrides={"driven_axes": ["wheel", *setup.axes]} if setup.axes else None,
        )
        self.setup = setup
        self.plant = Plant(config, bus["seed"], bus["rate_hz"])
        self.hub = MeasurementHub(make(HubParameters, "measurement_hub"))
        self.encoders = Encoders(make(EncoderParameters, "encoders"))
        self.drive = AxisDrive(make(DriveParameters, "wheel_drive"))
        self.controller = FreeRollingController(
            make(FreeRollingParameters, "free_rolling_controller")
        )
        self.sequencer = SlipSequencer(make(SequencerParameters, "slip_sequencer"))
        self.sources: dict[str | None, SlipSequencer | FreeRollingController] = {
            "slip": self.sequencer,
            "free_rolling": self.controller,
        }
        self._source: SlipSequencer | FreeRollingController | None = None
        self.axes: dict[str, TwinAxis] = {axis: make_axis(setup, axis) for axis in setup.axes}
        self.batch = setup.batch
        self.rate_hz = float(bus["rate_hz"])
        self.latest: Cycle | None = None
        self._commands: tuple[AxisCommand, ...] = ()

    @property
    def cores(self) -> dict[str, Any]:
        """Core of each node, by node name."""
        return {
            "measurement_hub": self.hub,
            "encoders": self.encoders,
            "wheel_drive": self.drive,
            "free_rolling_controller": self.controller,
            "slip_sequencer": self.sequencer,
        }

    def in_force(self) -> dict[str, dict[str, Any]]:
        """Present parameters of each node, by node name."""
        found = {name: to_mapping(core.parameters) for name, core in self.cores.items()}
        bus = self.setup.nodes()[-1]
        return {**found, bus.name: self.setup.of(bus)}

    def _active_source(self, inputs: BusInputs) -> SlipSequencer | FreeRollingController | None:
        """The source of the mode of the last cycle. It starts anew when its mode begins, and in
        each cycle while the drive is not in operation."""
        source = self.sources.get(self.drive.reference_source)
        begins = source is not self._source
        self._source = source
        if source is not None and (begins or not in_operation(inputs.axes[WHEEL].status_word)):
            source.reset()
        return source

    def cycle(self) -> Cycle:
        """Make one batch of bus cycles through the whole chain."""
        plant, hub, encoders = self.plant, self.hub, self.encoders
        commands = self._commands
        batch = tuple([plant.step(commands) for _ in range(self.batch)])
        for inputs in batch:
            hub_sample = hub.step(inputs)
            encoder_sample = encoders.step(inputs)
        source = self._active_source(inputs)
        reference = inside = None
        if source is not None:
            if isinstance(source, FreeRollingController):
                reference = source.step(hub_sample, encoder_sample)
            else:
                reference = source.step(encoder_sample)
            inside = source.state
        if source is not self.sequencer:
            # as in the node: requests are checked against the present plank position
            self.sequencer.watch(encoder_sample.plank_position, encoder_sample.cycle)
        command, drive_sample = self.drive.step(inputs, encoder_sample, hub_sample, reference)
        if self.axes:
            others = [a.step(inputs, encoder_sample, hub_sample) for a in self.axes.values()]
            self._commands = (command, *others)
        else:
            self._commands = (command,)
        self.latest = Cycle(
            batch, hub_sample, encoder_sample, reference, inside, command, drive_sample
        )
        return self.latest
