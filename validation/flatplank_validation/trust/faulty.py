# SPDX-License-Identifier: Apache-2.0
"""Places where a fault acts on the twin: between plant and cores, and between the cores and the
drive's node.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from flatplank_hw.bus.image import AXES, AxisCommand, BusInputs
from flatplank_hw.drive import AxisDrive
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Reference
from flatplank_sim.plant import Plant
from flatplank_sim.twin.twin import Twin

WHEEL = AXES.index("wheel")


class Fault:
    """A fault from its `begin` on; each method changes nothing by default."""

    lost_cycles = 0
    """cycles that do not reach the cores, at the beginning"""

    def begin(self, twin: Twin) -> None:
        """Act on the bench once."""

    def inputs(self, inputs: BusInputs) -> BusInputs:
        """What the cores get of the bus."""
        return inputs

    def command(self, command: AxisCommand) -> AxisCommand:
        """What the drive gets of the command."""
        return command

    def hub(self, sample: HubSample) -> HubSample:
        """What the drive's node gets of the hub."""
        return sample

    def encoders(self, sample: EncoderSample) -> EncoderSample:
        """What the drive's node gets of the encoders."""
        return sample

    def reference(self, reference: Reference | None) -> Reference | None:
        """What the drive's node gets of the source."""
        return reference


class FaultyPlant:
    """The plant behind a bus with faults; all else is the plant's own."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.faults: list[Fault] = []

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)  # for copies, which ask before there is a plant
        return getattr(self._plant, name)

    def step(self, commands: Iterable[AxisCommand]) -> BusInputs:
        """Make a bus cycle, or more when cycles are lost."""
        for fault in self.faults:
            commands = [fault.command(c) if c.axis == WHEEL else c for c in commands]
        lost = sum(fault.lost_cycles for fault in self.faults)
        for fault in self.faults:
            fault.lost_cycles = 0
        for _ in range(lost):
            self._plant.step(())
        inputs = self._plant.step(tuple(commands))
        for fault in self.faults:
            inputs = fault.inputs(inputs)
        return inputs


class FaultyDrive:
    """The drive's node behind topics with faults; all else is the drive's own."""

    def __init__(self, drive: AxisDrive) -> None:
        self._drive = drive
        self.faults: list[Fault] = []
        self.client = ""
        """client in charge that sends heartbeats"""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._drive, name)

    def step(
        self,
        inputs: BusInputs,
        encoders: EncoderSample,
        hub: HubSample,
        reference: Reference | None,
    ) -> tuple[AxisCommand, DriveSample]:
        """One cycle of the node."""
        if self.client:
            self._drive.heartbeat(self.client)
        for fault in self.faults:
            encoders, hub = fault.encoders(encoders), fault.hub(hub)
            reference = fault.reference(reference)
        return self._drive.step(inputs, encoders, hub, reference)


class FaultyTwin:
    """A twin that faults can be put into."""

    def __init__(self, twin: Twin) -> None:
        self.twin = twin
        self.plant, self.drive = FaultyPlant(twin.plant), FaultyDrive(twin.drive)
        twin.plant, twin.drive = self.plant, self.drive  # type: ignore[assignment]

    def begin(self, fault: Fault) -> None:
        """Let a fault act from the next cycle on."""
        fault.begin(self.twin)
        self.plant.faults.append(fault)
        self.drive.faults.append(fault)
