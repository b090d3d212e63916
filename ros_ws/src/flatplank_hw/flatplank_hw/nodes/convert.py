# SPDX-License-Identifier: Apache-2.0
"""Converts messages to the tuples of the cores and back, with unchanged values."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from struct import Struct
from typing import Any

from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Header

from flatplank_hw.bus.image import (
    AXES,
    CHANNELS,
    PER_CYCLE,
    AxisCommand,
    AxisInputs,
    BusInputs,
)
from flatplank_hw.drive import REASONS
from flatplank_hw.samples import SOURCES, DriveSample, EncoderSample, HubSample, Reference, Wrench
from flatplank_msgs.msg import BusInputs as BusInputsMsg
from flatplank_msgs.msg import BusOutputs, DriveStatus, EncoderState, HubState
from flatplank_msgs.msg import Reference as ReferenceMsg

NO_WRENCH = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_AXES = len(AXES)
_STAMP = Struct("<iI")
_CYCLE_ARRAYS = dict(zip(PER_CYCLE, "diiiiiB", strict=True))
"""array of a message with a value per cycle -> type code"""
_AXIS_ARRAYS = dict(zip(AxisInputs._fields, "HbiiiH", strict=True))
"""array of a message with a value per cycle and axis -> type code"""
_HUB, _ENCODERS, _DRIVE = HubSample._fields[4:], EncoderSample._fields[2:], DriveSample._fields[2:]
"""fields with the same name in the sample and its message"""


def set_stamp(header: Header, stamp_ns: int) -> None:
    header.stamp.sec, header.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)


def stamp_ns(header: Header) -> int:
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def raw_stamp_ns(cdr: bytes) -> int:
    """Stamp [ns] of a serialised message that begins with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(cdr, 4)
    return seconds * 1_000_000_000 + nanoseconds


def inputs_to_msg(batch: Sequence[BusInputs], period_ns: int, msg: BusInputsMsg, t0: int) -> None:
    """Fill `msg` with consecutive cycles; `t0` [ns] is added to the bench time."""
    last = batch[-1]
    set_stamp(msg.header, last.stamp_ns + t0)
    msg.cycle, msg.period_ns, msg.count, msg.health = (
        last.cycle, period_ns, len(batch), last.health,
    )  # fmt: skip
    msg.bridge_volts = array("d", [v for s in batch for v in s.bridge_volts])
    for name, code in _CYCLE_ARRAYS.items():
        setattr(msg, name, array(code, [getattr(s, name) for s in batch]))
    columns = zip(*[axis for s in batch for axis in s.axes], strict=True)
    for (name, code), column in zip(_AXIS_ARRAYS.items(), columns, strict=True):
        setattr(msg, name, array(code, column))


def inputs_from_msg(msg: BusInputsMsg) -> list[BusInputs]:
    """The cycles of a batch, oldest first."""
    n = msg.count
    stamp = stamp_ns(msg.header)
    rows = zip(*[getattr(msg, name) for name in _AXIS_ARRAYS], strict=True)
    axes = [AxisInputs._make(row) for row in rows]
    cycles = zip(*[getattr(msg, name) for name in _CYCLE_ARRAYS], strict=True)
    volts = msg.bridge_volts
    batch = []
    for k, values in enumerate(cycles):
        back = n - 1 - k
        bridges = tuple(volts[CHANNELS * k : CHANNELS * (k + 1)])
        own = tuple(axes[_AXES * k : _AXES * (k + 1)])
        head = (msg.cycle - back, stamp - back * msg.period_ns, bridges)
        batch.append(BusInputs._make((*head, *values, msg.health, own)))
    return batch


def command_to_msg(command: AxisCommand, stamp: int, msg: BusOutputs) -> None:
    set_stamp(msg.header, stamp)
    for name, value in zip(AxisCommand._fields, command, strict=True):
        setattr(msg, name, value)


def command_from_msg(msg: BusOutputs) -> AxisCommand:
    return AxisCommand(*[getattr(msg, name) for name in AxisCommand._fields])


def _to_msg(sample: Any, msg: Any, names: Sequence[str]) -> None:
    """Fill stamp, cycle and the fields `names`, which are the same in sample and message."""
    set_stamp(msg.header, sample.stamp_ns)
    msg.cycle = sample.cycle
    for name in names:
        setattr(msg, name, getattr(sample, name))


def wrench_to_msg(wrench: Wrench, stamp: int, msg: WrenchStamped) -> None:
    set_stamp(msg.header, stamp)
    force, torque = msg.wrench.force, msg.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = wrench


def wrench_from_msg(msg: WrenchStamped) -> Wrench:
    force, torque = msg.wrench.force, msg.wrench.torque
    return Wrench(force.x, force.y, force.z, torque.x, torque.y, torque.z)


def hub_to_msg(sample: HubSample, msg: HubState) -> None:
    _to_msg(sample, msg, _HUB)


def hub_from_msg(msg: HubState) -> HubSample:
    """Hub sample without wrenches: these have their own topics and are zero here."""
    values = [getattr(msg, name) for name in _HUB]
    return HubSample(msg.cycle, stamp_ns(msg.header), NO_WRENCH, NO_WRENCH, *values)


def hub_of_contact(contact: Wrench, encoders: EncoderSample) -> HubSample:
    """Hub sample with the contact wrench alone, for the free-rolling controller."""
    nan = math.nan
    return HubSample(
        encoders.cycle, encoders.stamp_ns, NO_WRENCH, contact, nan, nan, nan, False, 0
    )


def encoders_to_msg(sample: EncoderSample, msg: EncoderState) -> None:
    _to_msg(sample, msg, _ENCODERS)


def encoders_from_msg(msg: EncoderState) -> EncoderSample:
    values = [getattr(msg, name) for name in _ENCODERS]
    return EncoderSample(msg.cycle, stamp_ns(msg.header), *values)


def reference_to_msg(reference: Reference, msg: ReferenceMsg) -> None:
    set_stamp(msg.header, reference.stamp_ns)
    msg.cycle, msg.source = reference.cycle, SOURCES.index(reference.source)
    msg.value, msg.valid = reference.value, reference.valid


def reference_from_msg(msg: ReferenceMsg) -> Reference:
    return Reference(msg.cycle, stamp_ns(msg.header), SOURCES[msg.source], msg.value, msg.valid)


def drive_to_msg(sample: DriveSample, msg: DriveStatus) -> None:
    _to_msg(sample, msg, _DRIVE)
    msg.stop_text = REASONS[sample.stop_reason]


def drive_from_msg(msg: DriveStatus) -> DriveSample:
    return DriveSample(msg.cycle, stamp_ns(msg.header), *[getattr(msg, name) for name in _DRIVE])
