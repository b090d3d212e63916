# SPDX-License-Identifier: Apache-2.0
"""Converts messages to the tuples of the cores, with unchanged values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from struct import Struct
from typing import Any, NamedTuple

from builtin_interfaces.msg import Time
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
from flatplank_hw.samples import (
    SOURCES,
    DriveSample,
    EncoderSample,
    HubSample,
    Reference,
    Wrench,
)
from flatplank_msgs.msg import BusInputs as BusInputsMsg
from flatplank_msgs.msg import BusOutputs, DriveStatus, EncoderState, HubState, OperationMode
from flatplank_msgs.msg import Reference as ReferenceMsg


class Batch(NamedTuple):
    """Consecutive bus cycles, oldest first, with stamps as in their message."""

    cycles: Sequence[BusInputs]
    period_ns: int


class StampedCommand(NamedTuple):
    """Command of an axis and the stamp of the inputs that it answers [ns]."""

    stamp_ns: int
    command: AxisCommand


class StampedMode(NamedTuple):
    """Operation mode of a drive and the stamp of the last inputs before it is followed [ns]."""

    stamp_ns: int
    mode: str


class StampedWrench(NamedTuple):
    """Wrench and the stamp of its inputs [ns]."""

    stamp_ns: int
    wrench: Wrench


class StampedState(NamedTuple):
    """State of a source of references: a named tuple with the names of its message."""

    stamp_ns: int
    cycle: int
    state: Any


NO_WRENCH = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_AXES = len(AXES)
_STAMP = Struct("<iI")
_HUB, _ENCODERS, _DRIVE = HubSample._fields[4:], EncoderSample._fields[2:], DriveSample._fields[2:]
"""fields with the same name in the sample and its message"""


def set_time(time: Time, stamp_ns: int) -> None:
    time.sec, time.nanosec = divmod(stamp_ns, 1_000_000_000)


def set_stamp(header: Header, stamp_ns: int) -> None:
    set_time(header.stamp, stamp_ns)


def stamp_ns(header: Header) -> int:
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def raw_stamp_ns(cdr: bytes) -> int:
    """Stamp [ns] of a serialised message that begins with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(cdr, 4)
    return seconds * 1_000_000_000 + nanoseconds


def batch_of(cycles: Sequence[BusInputs], period_ns: int, t0: int) -> Batch:
    """Batch of consecutive cycles; `t0` [ns] is added to their stamps. As in their message, the
    stamps follow from the last one and all cycles have its health."""
    last = cycles[-1]
    end, health = last.stamp_ns + t0, last.health
    same = [
        cycle._replace(stamp_ns=end - (last.cycle - cycle.cycle) * period_ns, health=health)
        for cycle in cycles
    ]
    return Batch(same, period_ns)


def inputs_from_msg(msg: BusInputsMsg) -> Batch:
    """The cycles of a batch, oldest first."""
    n = msg.count
    stamp = stamp_ns(msg.header)
    rows = zip(*[getattr(msg, name) for name in AxisInputs._fields], strict=True)
    axes = [AxisInputs._make(row) for row in rows]
    cycles = zip(*[getattr(msg, name) for name in PER_CYCLE], strict=True)
    volts = msg.bridge_volts
    batch: list[BusInputs] = []
    for k, values in enumerate(cycles):
        back = n - 1 - k
        bridges = tuple(volts[CHANNELS * k : CHANNELS * (k + 1)])
        own = tuple(axes[_AXES * k : _AXES * (k + 1)])
        head = (msg.cycle - back, stamp - back * msg.period_ns, bridges)
        batch.append(BusInputs._make((*head, *values, msg.health, own)))
    return Batch(batch, msg.period_ns)


def command_from_msg(msg: BusOutputs) -> StampedCommand:
    command = AxisCommand(*[getattr(msg, name) for name in AxisCommand._fields])
    return StampedCommand(stamp_ns(msg.header), command)


def mode_from_msg(msg: OperationMode) -> StampedMode:
    return StampedMode(stamp_ns(msg.header), msg.mode)


def wrench_from_msg(msg: WrenchStamped) -> StampedWrench:
    force, torque = msg.wrench.force, msg.wrench.torque
    wrench = Wrench(force.x, force.y, force.z, torque.x, torque.y, torque.z)
    return StampedWrench(stamp_ns(msg.header), wrench)


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


def encoders_from_msg(msg: EncoderState) -> EncoderSample:
    values = [getattr(msg, name) for name in _ENCODERS]
    return EncoderSample(msg.cycle, stamp_ns(msg.header), *values)


def reference_from_msg(msg: ReferenceMsg) -> Reference:
    return Reference(msg.cycle, stamp_ns(msg.header), SOURCES[msg.source], msg.value, msg.valid)


def drive_from_msg(msg: DriveStatus) -> DriveSample:
    return DriveSample(msg.cycle, stamp_ns(msg.header), *[getattr(msg, name) for name in _DRIVE])
