# SPDX-License-Identifier: Apache-2.0
"""The faults: of sensors, bus, nodes, references, drive, plank, emergency stop and operator."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flatplank_hw.bus.image import AxisCommand, BusInputs, Health
from flatplank_hw.samples import EncoderSample, HubSample, Reference
from flatplank_sim.twin.twin import Twin
from flatplank_validation.trust.faulty import WHEEL, Fault, FaultyDrive


@dataclass
class Volts(Fault):
    """A bridge or the LVDT (channel 6) gives a value, or none changes any more (None)."""

    channel: int
    value: float | None = None

    def inputs(self, inputs: BusInputs) -> BusInputs:
        analogue = [*inputs.bridge_volts, inputs.lvdt_volts]
        if self.value is None:
            self.value = analogue[self.channel]
        analogue[self.channel] = self.value
        c1, c2, c3, c4, c5, c6, lvdt = analogue
        return inputs._replace(bridge_volts=(c1, c2, c3, c4, c5, c6), lvdt_volts=lvdt)


@dataclass
class Frozen(Fault):
    """Counters do not change any more; '' freezes the whole image, whose number goes on."""

    name: str
    kept: Any = None

    def inputs(self, inputs: BusInputs) -> BusInputs:
        if not self.name:
            self.kept = self.kept or inputs
            return self.kept._replace(cycle=inputs.cycle, stamp_ns=inputs.stamp_ns)
        if self.kept is None:
            self.kept = getattr(inputs, self.name)
        return inputs._replace(**{self.name: self.kept})


@dataclass
class Hung(Fault):
    """The inputs of the drive do not change any more, while those of the others do."""

    kept: Any = None

    def inputs(self, inputs: BusInputs) -> BusInputs:
        self.kept = self.kept or inputs.axes[WHEEL]
        axes = list(inputs.axes)
        axes[WHEEL] = self.kept
        return inputs._replace(axes=tuple(axes))


@dataclass
class Clock(Fault):
    """The clock of the bus jumps, and runs on from there."""

    seconds: float

    def inputs(self, inputs: BusInputs) -> BusInputs:
        return inputs._replace(stamp_ns=inputs.stamp_ns + round(self.seconds * 1e9))


@dataclass
class Jump(Fault):
    """A counter jumps by half a turn of its encoder."""

    name: str

    def inputs(self, inputs: BusInputs) -> BusInputs:
        return inputs._replace(**{self.name: getattr(inputs, self.name) + 10_000})


@dataclass
class BadBus(Fault):
    """The master says that the bus is bad."""

    health: Health

    def inputs(self, inputs: BusInputs) -> BusInputs:
        return inputs._replace(health=int(self.health))


class LostCycles(Fault):
    """No cycle reaches the nodes for 0.1 s."""

    def __init__(self) -> None:
        self.lost_cycles = 25


@dataclass
class Silent(Fault):
    """A node hangs: its last sample stays."""

    node: str
    kept: Any = None

    def _stay(self, node: str, sample: Any) -> Any:
        if node != self.node:
            return sample
        self.kept = self.kept or sample
        return self.kept

    def hub(self, sample: HubSample) -> HubSample:
        return self._stay("hub", sample)

    def encoders(self, sample: EncoderSample) -> EncoderSample:
        return self._stay("encoders", sample)

    def reference(self, reference: Reference | None) -> Reference | None:
        return self._stay("reference", reference)


@dataclass
class BadReference(Fault):
    """The source sends a value, said to be valid or not."""

    value: float
    valid: bool = True

    def reference(self, reference: Reference | None) -> Reference | None:
        if reference is None:
            return None
        return reference._replace(value=self.value, valid=self.valid)


@dataclass
class Deaf(Fault):
    """The drive keeps its last set-point, and its last control word, too, when it obeys no
    command at all. The watchdog of its bus chip runs on."""

    entirely: bool
    kept: AxisCommand | None = None

    def command(self, command: AxisCommand) -> AxisCommand:
        self.kept = kept = self.kept or command
        word = kept.control_word if self.entirely else command.control_word
        return kept._replace(cycle=command.cycle, control_word=word)


@dataclass
class Once(Fault):
    """Something happens to the bench."""

    act: Callable[[Twin], Any]

    def begin(self, twin: Twin) -> None:
        self.act(twin)


class NoHeartbeat(Fault):
    """The client in charge is gone."""

    def begin(self, twin: Twin) -> None:
        drive: FaultyDrive = twin.drive  # type: ignore[assignment]
        drive.client = ""


class SwitchedOff(Fault):
    """The drive is switched off at its own display for a moment."""

    cycles = 5

    def command(self, command: AxisCommand) -> AxisCommand:
        self.cycles -= 1
        return command._replace(control_word=0) if self.cycles >= 0 else command


FAULTS: dict[str, Callable[[], Fault]] = {
    "bridge NaN": lambda: Volts(5, math.nan),
    "bridge Inf": lambda: Volts(5, math.inf),
    "bridge 1e308": lambda: Volts(4, -1e308),
    "bridge frozen": lambda: Volts(2),
    "LVDT Inf": lambda: Volts(6, math.inf),
    "plank encoder frozen": lambda: Frozen("plank_counts"),
    "plank encoder jumps": lambda: Jump("plank_counts"),
    "wheel encoder frozen": lambda: Frozen("wheel_counts"),
    "image frozen": lambda: Frozen(""),
    "drive image frozen": Hung,
    "bus lost": lambda: BadBus(Health.LOST),
    "bus stale": lambda: BadBus(Health.STALE),
    "cycles lost": LostCycles,
    "hub hangs": lambda: Silent("hub"),
    "encoders hang": lambda: Silent("encoders"),
    "source hangs": lambda: Silent("reference"),
    "reference invalid": lambda: BadReference(0.2, valid=False),
    "reference NaN": lambda: BadReference(math.nan),
    "reference Inf": lambda: BadReference(math.inf),
    "reference -Inf": lambda: BadReference(-math.inf),
    "reference 1e308": lambda: BadReference(1e308),
    "drive fault": lambda: Once(lambda t: t.plant.inject_fault("wheel")),
    "drive deaf to set-points": lambda: Deaf(entirely=False),
    "drive deaf": lambda: Deaf(entirely=True),
    "drive switched off": SwitchedOff,
    "motor blocked": lambda: Once(lambda t: t.plant.stick("wheel")),
    "plank stops": lambda: Once(lambda t: t.plant.operator.plank(0)),
    "plank reverses": lambda: Once(lambda t: t.plant.operator.plank(-1)),
    "plank slow": lambda: Once(lambda t: t.plant.operator.fast(False)),
    "emergency stop": lambda: Once(lambda t: t.plant.operator.emergency_stop()),
    "heartbeat gone": NoHeartbeat,
    "quick stop": lambda: Once(lambda t: t.drive.quick_stop()),
    "told to stand": lambda: Once(lambda t: t.drive.set_operation_mode("velocity", 0.0)),
    "disabled": lambda: Once(lambda t: t.drive.disable()),
    "reset and enabled": lambda: Once(lambda t: (t.drive.reset_fault(), t.drive.enable())),
}
"""name -> a new fault"""
CLOCK: dict[str, Callable[[], Fault]] = {
    "clock an hour ahead": lambda: Clock(3600.0),
    "clock an hour back": lambda: Clock(-3600.0),
    "clock a second ahead": lambda: Clock(1.0),
    "clock a second back": lambda: Clock(-1.0),
    "clock a cycle back": lambda: Clock(-0.004),
}
"""jumps of the clock, each with every other fault in a row of their own"""
