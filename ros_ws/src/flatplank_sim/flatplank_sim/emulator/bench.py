# SPDX-License-Identifier: Apache-2.0
"""The emulated bench: slaves, plant and bench time. Frames and elapsed time are arguments."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from flatplank_hw.bus.image import AxisCommand, BusInputs
from flatplank_hw.ethercat.busfile import BusFile
from flatplank_sim.emulator.coupling import Coupling
from flatplank_sim.emulator.motion_monitor import MotionMonitor
from flatplank_sim.emulator.segment import Segment
from flatplank_sim.emulator.slave import EmulatedSlave


class PlantLike(Protocol):
    """Interface of a plant for the emulator."""

    def step(self, commands: Sequence[AxisCommand]) -> BusInputs:
        """Advance by one bus cycle and return its inputs."""


class EmulatedBench:
    """Emulated bench. Each process data frame advances bench time by one period; without frames
    the runner calls `step`."""

    def __init__(self, bus: BusFile, plant: PlantLike) -> None:
        self.bus = bus
        self.plant = plant
        self.slaves = [EmulatedSlave(spec) for spec in bus.slaves]
        self.segment = Segment(self.slaves)
        self.segment.exchange = self._exchange
        self.coupling = Coupling(self.slaves)
        self.monitor = MotionMonitor()
        self.cycle = 0
        self.now = 0
        """bench time [ns]"""
        self.inputs: BusInputs | None = None
        self._agenda: list[tuple[int, Callable[[], object]]] = []

    def slave(self, name: str) -> EmulatedSlave:
        """Slave by name."""
        return next(s for s in self.slaves if s.spec.name == name)

    def frame(self, frame: bytes) -> bytearray | None:
        """Pass one frame through the segment; process data step the plant."""
        return self.segment.process(frame, self.now)

    def _exchange(self) -> None:
        self.step()
        self.monitor.last_frame = self.now

    def step(self) -> None:
        """Step the plant and the firmware of every drive by one bus cycle."""
        self.cycle += 1
        self.now += self.bus.period_ns
        self._fire()
        answered = self.inputs.cycle if self.inputs is not None else 0
        commands = self.coupling.commands(answered, self.now)
        self.inputs = self.plant.step(commands)
        truth = getattr(self.plant, "truth", None)
        self.monitor.register_cycle(
            self.now, self.inputs, truth.wheel_velocity if truth is not None else None
        )
        self.coupling.publish(self.inputs, self.now)
        for slave in self.slaves:
            slave.tick(self.now)
        self.monitor.register_states(self.now, all([slave.operational for slave in self.slaves]))

    def call_at(self, cycle: int, action: Callable[[], object]) -> None:
        """Call `action` when the bench reaches a cycle; at once when it has passed."""
        if cycle <= self.cycle:
            action()
        else:
            self._agenda.append((cycle, action))

    def _fire(self) -> None:
        if self._agenda:
            due = [action for cycle, action in self._agenda if cycle <= self.cycle]
            self._agenda = [item for item in self._agenda if item[0] > self.cycle]
            for action in due:
                action()


def make_plant(
    spec: str, rate_hz: int, seed: int, options: dict[str, str], axes: Sequence[str]
) -> PlantLike:
    """Make a plant: 'simulated', or 'module:function', called with rate_hz, seed and the options.

    axes: axes with a drive on the bus.
    """
    if spec == "simulated":
        return _simulated(rate_hz, seed, options, axes)
    module, _, name = spec.partition(":")
    try:
        factory: Any = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ValueError(
            f"plant '{spec}': {error}; give 'simulated' or 'module:function'"
        ) from None
    return factory(rate_hz=rate_hz, seed=seed, **options)


def _simulated(rate_hz: int, seed: int, options: dict[str, str], axes: Sequence[str]) -> PlantLike:
    from flatplank_sim.plant import Plant, PlantConfig

    tire = options.get("tire", "toyo")
    config = PlantConfig.load(
        tire,
        preset=options.get("preset") or None,
        file=options.get("config") or None,
        overrides={"driven_axes": list(axes)},
    )
    return Plant(config, seed, rate_hz)
