# SPDX-License-Identifier: Apache-2.0
"""Couples the process data of the slaves to the plant, by the channels of the bus file."""

from __future__ import annotations

from collections.abc import Callable

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital
from flatplank_hw.cia402 import TORQUE_UNIT
from flatplank_hw.ethercat import busfile
from flatplank_hw.ethercat.busfile import Entry
from flatplank_hw.ethercat.layout import range_of_type
from flatplank_sim.emulator.drive_firmware import IDLE, DriveFirmware, DriveWords
from flatplank_sim.emulator.slave import EmulatedSlave

Getter = Callable[[BusInputs], int]


class Coupling:
    """Reads the commands from the slaves and writes the inputs of the plant to them."""

    def __init__(self, slaves: list[EmulatedSlave]) -> None:
        self.slaves = slaves
        self.drives = {
            AXES.index(s.spec.axis): DriveFirmware(AXES.index(s.spec.axis), s)
            for s in slaves
            if s.spec.axis
        }
        self.overrides: dict[str, int] = {}
        """injected faults: channel -> raw value in place of that of the plant"""
        self._asked: dict[int, DriveWords] = dict.fromkeys(self.drives, IDLE)
        self._compiled: dict[str, tuple[int, list[Getter | None]]] = {}

    def commands(self, cycle: int, now: int) -> tuple[AxisCommand, ...]:
        """Commands of the slaves to the plant, in answer to the inputs of `cycle`."""
        asked: dict[str, int] = {}
        outputs = 0
        for slave in self.slaves:
            if not slave.operational or not slave.spec.outputs:
                continue
            for entry, value in zip(slave.outputs.entries, slave.fetch_outputs(), strict=True):
                if entry.channel == busfile.DIGITAL_OUTPUTS:
                    outputs = value
                elif entry.unit_nm:
                    asked[entry.channel] = round(value * entry.unit_nm / TORQUE_UNIT)
                else:
                    asked[entry.channel] = value
        commands = []
        for axis, drive in self.drives.items():
            name = AXES[axis]
            word, mode, position, velocity, torque = (
                asked.get(f"{name}.{output}", 0) for output in busfile.AXIS_OUTPUTS
            )
            self._asked[axis] = word, mode, position, velocity, torque
            command = drive.command(self._asked[axis], cycle, now)
            commands.append(command._replace(digital_outputs=outputs))
        return tuple(commands)

    def publish(self, inputs: BusInputs, now: int) -> None:
        """Write the plant's inputs to the memories of the slaves."""
        safe = not inputs.digital & Digital.EMERGENCY_STOP_OK
        axes = list(inputs.axes)
        for axis, drive in self.drives.items():
            drive.safe_stop = safe
            axes[axis] = drive.report(axes[axis], self._asked[axis], now)
        inputs = inputs._replace(axes=tuple(axes))
        for slave in self.slaves:
            if slave.inputs.entries:
                slave.store_inputs(self._values(slave, inputs))

    def _values(self, slave: EmulatedSlave, inputs: BusInputs) -> tuple[int, ...]:
        version, getters = self._compiled.get(slave.spec.name, (-1, []))
        if version != slave.inputs.version:
            getters = [_getter(entry) for entry in slave.inputs.entries]
            self._compiled[slave.spec.name] = (slave.inputs.version, getters)
        values = tuple([get(inputs) if get is not None else 0 for get in getters])
        if self.overrides:
            names = [entry.channel for entry in slave.inputs.entries]
            values = tuple(self.overrides.get(n, v) for n, v in zip(names, values, strict=True))
        return values


def _getter(entry: Entry) -> Getter | None:
    """Function from the plant's inputs to the raw value of an entry; None: it stays zero."""
    name = entry.channel
    axis, _, word = name.partition(".")
    if name in busfile.DIGITAL:
        mask = int(busfile.DIGITAL[name])
        return lambda inputs: 1 if inputs.digital & mask else 0
    if word and word != "torque":
        k, place = AXES.index(axis), AxisInputs._fields.index(word)
        return lambda inputs: inputs.axes[k][place]
    if name not in busfile.VOLTS and name not in busfile.COUNTS and not word:
        return None
    low, high = range_of_type(entry.kind)
    if name in busfile.COUNTS:
        return lambda inputs: (getattr(inputs, name) - low) % (high - low + 1) + low
    if word:
        k, unit = AXES.index(axis), TORQUE_UNIT / entry.unit_nm
        return lambda inputs: max(low, min(high, round(inputs.axes[k].torque * unit)))
    scale = entry.full_scale_counts / entry.full_scale_volts
    if name == "lvdt":
        return lambda inputs: max(low, min(high, round(inputs.lvdt_volts * scale)))
    number = busfile.VOLTS.index(name)
    return lambda inputs: max(low, min(high, round(inputs.bridge_volts[number] * scale)))
