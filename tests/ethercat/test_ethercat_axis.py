# SPDX-License-Identifier: Apache-2.0
"""The project's own axis core on the emulated bus: five axes, every mode, faults and resets."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import pytest
from ethercat_rig import BUS_FILES, be_quick, namespace
from stalls import GraphStalls, LongestWait, undisturbed

from flatplank_hw.bus.image import AXES, BusInputs
from flatplank_hw.cia402 import State
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.ethercat.master import BusClient
from flatplank_hw.samples import DriveSample
from flatplank_sim.emulated import EmulatedBus

RULES = ("inputs", "drive_fault", "emergency_stop", "speed", "torque")
MILLI = 0.001
PARAMETERS = {
    "wheel": DriveParameters(rules=RULES),
    "plank": DriveParameters(
        axis="plank", gear_ratio=1.0, output_per_turn=0.5 * MILLI, unit="m", speed_limit=0.04,
        speed_trip=0.06, move_speed=0.02, standstill_speed=0.0005, rules=RULES,
    ),
    "steer": DriveParameters(
        axis="steer", gear_ratio=1000.0, speed_limit=0.06, speed_trip=0.1, move_speed=0.05,
        standstill_speed=0.001, rules=RULES,
    ),
    "vertical": DriveParameters(
        axis="vertical", gear_ratio=1.0, output_per_turn=0.2 * MILLI, unit="m", speed_limit=0.005,
        speed_trip=0.01, move_speed=0.004, standstill_speed=0.0002, rules=RULES,
    ),
    "camber": DriveParameters(
        axis="camber", gear_ratio=1000.0, speed_limit=0.06, speed_trip=0.1, move_speed=0.05,
        standstill_speed=0.001, rules=RULES,
    ),
}  # fmt: skip


class Axes:
    """All drive cores around one bus, as their nodes would be."""

    def __init__(self, bus: EmulatedBus, client: BusClient, waits: LongestWait) -> None:
        self.bus, self.client, self.waits = bus, client, waits
        self.cores = {name: AxisDrive(p) for name, p in PARAMETERS.items()}
        self.samples: dict[str, DriveSample] = {}
        self.inputs: BusInputs | None = None

    def run(self, until: Callable[[], bool], seconds: float = 8.0) -> None:
        """Cycle until a condition holds."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for inputs in self.client.poll():
                self.inputs = inputs
                for name, core in self.cores.items():
                    command, self.samples[name] = core.step(inputs, None, None, None)
                    self.client.send(command)
            if self.inputs is not None and until():
                return
        pytest.fail(f"not reached; {self.samples} {self.client.diagnostics()}")

    def cycles(self, count: int) -> None:
        start = self.inputs.cycle if self.inputs else 0
        self.run(lambda: self.inputs.cycle >= start + count)

    def ask(self, name: str, request: str, *values: object) -> None:
        """A request that must be accepted."""
        answer = getattr(self.cores[name], request)(*values)
        assert answer.accepted, f"{name}.{request}: {answer.reason}"

    def off(self, name: str) -> bool:
        """Whether the power stage is off and no fault is there."""
        return self.samples[name].state in (State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON)

    def undisturbed(self, scenario: Callable[[], None]) -> None:
        """Make a scenario from rest; once more where it failed beside a stall of the computer, for
        a drive whose commands are too old is rightly stopped."""

        def from_rest() -> None:
            self.rest()
            scenario()

        undisturbed(lambda: GraphStalls(self.bus.emulator.send, self.waits), from_rest)

    def rest(self) -> None:
        """No drive is in fault or enabled."""
        for name, sample in self.samples.items():
            if sample.state == State.FAULT:
                self.ask(name, "reset_fault")
            elif not self.off(name):
                self.ask(name, "disable")
        self.run(lambda: all(self.off(name) for name in AXES))

    def enable(self, name: str) -> None:
        self.ask(name, "enable")
        self.run(lambda: self.samples[name].state == State.OPERATION_ENABLED)


@pytest.fixture(scope="module")
def axes() -> Iterator[Axes]:
    namespace().close()
    with EmulatedBus(BUS_FILES / "bench_five_axes.yaml") as bus, LongestWait() as waits:
        client = bus.client()
        client.start()
        be_quick(True)
        made = Axes(bus, client, waits)
        made.cycles(10)
        bus.operate("unload")
        made.cycles(10)
        yield made
        be_quick(False)
        client.stop()


@pytest.mark.parametrize("name", AXES)
def test_an_axis_through_all_its_modes(axes: Axes, name: str) -> None:
    axes.undisturbed(lambda: all_modes(axes, name))


def all_modes(axes: Axes, name: str) -> None:
    core, p = axes.cores[name], PARAMETERS[name]
    axes.enable(name)
    others = [n for n in AXES if n != name and axes.samples[n].state == State.OPERATION_ENABLED]
    assert others == [], "only the axis that was asked for"
    axes.ask(name, "home")
    axes.run(lambda: core.at_target and abs(core.position) < 1e-6)
    step = p.move_speed * 0.5
    axes.ask(name, "move_to", step)
    axes.run(lambda: core.at_target)
    axes.cycles(30)
    assert axes.samples[name].position == pytest.approx(step, abs=0.02 * step)
    axes.ask(name, "set_operation_mode", "velocity", -p.move_speed)
    axes.run(lambda: axes.samples[name].velocity < -0.95 * p.move_speed)
    axes.ask(name, "quick_stop")
    axes.run(lambda: abs(axes.samples[name].velocity) < p.standstill_speed)
    axes.run(lambda: axes.off(name))
    axes.enable(name)
    axes.ask(name, "set_operation_mode", "torque", 0.05)
    axes.cycles(10)
    assert axes.inputs.axes[AXES.index(name)].mode_display == 10
    axes.ask(name, "disable")
    axes.run(lambda: axes.off(name))


@pytest.mark.parametrize("name", AXES)
def test_fault_reset_and_back(axes: Axes, name: str) -> None:
    """A drive fault reaches its own core only; after the reset nothing is enabled."""
    axes.undisturbed(lambda: fault_and_reset(axes, name))


def fault_and_reset(axes: Axes, name: str) -> None:
    axes.enable(name)
    axes.bus.emulator.send("drive_fault", axis=name, code=0x3210)
    axes.run(lambda: axes.samples[name].state == State.FAULT)
    assert axes.samples[name].error_code == 0x3210
    assert not axes.cores[name].enable().accepted
    axes.ask(name, "reset_fault")
    axes.run(lambda: axes.off(name))
    axes.cycles(50)
    assert axes.off(name)
    axes.enable(name)
    axes.ask(name, "disable")
    axes.run(lambda: axes.off(name))


def test_loss_of_the_bus_stops_all_axes_until_each_is_reset(axes: Axes) -> None:
    axes.undisturbed(lambda: loss_of_the_bus(axes))


def loss_of_the_bus(axes: Axes) -> None:
    for name in AXES:
        axes.enable(name)
    axes.bus.emulator.send("wire_dead", cycles=60)
    axes.run(lambda: axes.inputs.health != 0)
    axes.run(lambda: axes.inputs.health == 0)
    axes.cycles(50)
    assert {s.state for s in axes.samples.values()} == {State.FAULT}
    for name in AXES:
        axes.ask(name, "reset_fault")
    axes.run(lambda: all(axes.off(name) for name in AXES))
    axes.cycles(50)
    shaft = axes.bus.emulator.send("motion")["axes"]
    assert not any(shaft[name]["enabled"] for name in AXES)
    axes.enable("wheel")
    axes.ask("wheel", "disable")
    axes.cycles(20)
