# SPDX-License-Identifier: Apache-2.0
"""Converts messages to the tuples of the cores and back, with unchanged values."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from struct import Struct
from typing import Any, NamedTuple

from builtin_interfaces.msg import Time
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
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
from flatplank_hw.samples import (
    JOINTS,
    SOURCES,
    DriveSample,
    EncoderSample,
    HubSample,
    Reference,
    Wrench,
)
from flatplank_msgs.msg import BusInputs as BusInputsMsg
from flatplank_msgs.msg import BusOutputs, DriveStatus, EncoderState, HubState
from flatplank_msgs.msg import Reference as ReferenceMsg


class Exchange(NamedTuple):
    """How the samples of a topic become messages and samples again."""

    msg_type: type
    fill: Callable[[Any, Any], None]
    """`fill(sample, message)`"""
    read: Callable[[Any], Any]
    """message -> sample"""


class Batch(NamedTuple):
    """Consecutive bus cycles, oldest first, with stamps as in their message."""

    cycles: Sequence[BusInputs]
    period_ns: int


class StampedCommand(NamedTuple):
    """Command of an axis and the stamp of the inputs that it answers [ns]."""

    stamp_ns: int
    command: AxisCommand


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
_CYCLE_ARRAYS = dict(zip(PER_CYCLE, "diiiiiB", strict=True))
"""array of a message with a value per cycle -> type code"""
_AXIS_ARRAYS = dict(zip(AxisInputs._fields, "HbiiiH", strict=True))
"""array of a message with a value per cycle and axis -> type code"""
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


def inputs_to_msg(batch: Batch, msg: BusInputsMsg) -> None:
    """Fill `msg` with consecutive cycles."""
    cycles, period_ns = batch
    last = cycles[-1]
    set_stamp(msg.header, last.stamp_ns)
    msg.cycle, msg.period_ns, msg.count, msg.health = (
        last.cycle, period_ns, len(cycles), last.health,
    )  # fmt: skip
    msg.bridge_volts = array("d", [v for s in cycles for v in s.bridge_volts])
    for name, code in _CYCLE_ARRAYS.items():
        setattr(msg, name, array(code, [getattr(s, name) for s in cycles]))
    columns = zip(*[axis for s in cycles for axis in s.axes], strict=True)
    for (name, code), column in zip(_AXIS_ARRAYS.items(), columns, strict=True):
        setattr(msg, name, array(code, column))


def inputs_from_msg(msg: BusInputsMsg) -> Batch:
    """The cycles of a batch, oldest first."""
    n = msg.count
    stamp = stamp_ns(msg.header)
    rows = zip(*[getattr(msg, name) for name in _AXIS_ARRAYS], strict=True)
    axes = [AxisInputs._make(row) for row in rows]
    cycles = zip(*[getattr(msg, name) for name in _CYCLE_ARRAYS], strict=True)
    volts = msg.bridge_volts
    batch: list[BusInputs] = []
    for k, values in enumerate(cycles):
        back = n - 1 - k
        bridges = tuple(volts[CHANNELS * k : CHANNELS * (k + 1)])
        own = tuple(axes[_AXES * k : _AXES * (k + 1)])
        head = (msg.cycle - back, stamp - back * msg.period_ns, bridges)
        batch.append(BusInputs._make((*head, *values, msg.health, own)))
    return Batch(batch, msg.period_ns)


def command_to_msg(stamped: StampedCommand, msg: BusOutputs) -> None:
    set_stamp(msg.header, stamped.stamp_ns)
    for name, value in zip(AxisCommand._fields, stamped.command, strict=True):
        setattr(msg, name, value)


def command_from_msg(msg: BusOutputs) -> StampedCommand:
    command = AxisCommand(*[getattr(msg, name) for name in AxisCommand._fields])
    return StampedCommand(stamp_ns(msg.header), command)


def _to_msg(sample: Any, msg: Any, names: Sequence[str]) -> None:
    """Fill stamp, cycle and the fields `names`, which are the same in sample and message."""
    set_stamp(msg.header, sample.stamp_ns)
    msg.cycle = sample.cycle
    for name in names:
        setattr(msg, name, getattr(sample, name))


def wrench_to_msg(stamped: StampedWrench, msg: WrenchStamped) -> None:
    set_stamp(msg.header, stamped.stamp_ns)
    force, torque = msg.wrench.force, msg.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = stamped.wrench


def wrench_from_msg(msg: WrenchStamped) -> StampedWrench:
    force, torque = msg.wrench.force, msg.wrench.torque
    wrench = Wrench(force.x, force.y, force.z, torque.x, torque.y, torque.z)
    return StampedWrench(stamp_ns(msg.header), wrench)


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


def joints_of_encoders(sample: EncoderSample, msg: JointState) -> None:
    """Plank [m], wheel, steering and road camber angle [rad]."""
    set_stamp(msg.header, sample.stamp_ns)
    msg.name = list(JOINTS)
    angles = sample.wheel_angle, sample.steer_angle, sample.road_camber
    msg.position = array("d", (sample.plank_position, *angles))
    msg.velocity = array("d", (sample.plank_velocity, sample.wheel_velocity, 0.0, 0.0))


def joint_of_axis(axis: str) -> Exchange:
    """Exchange of drive samples with the joint state of one axis by its motor encoder."""

    def fill(sample: DriveSample, msg: JointState) -> None:
        set_stamp(msg.header, sample.stamp_ns)
        msg.name = [axis]
        msg.position = array("d", (sample.position,))
        msg.velocity = array("d", (sample.velocity,))
        msg.effort = array("d", (sample.torque,))

    return Exchange(JointState, fill, _only_published)


def state_exchange(msg_type: type) -> Exchange:
    """Exchange of the state of a source of references."""

    def fill(stamped: StampedState, msg: Any) -> None:
        set_stamp(msg.header, stamped.stamp_ns)
        msg.cycle = stamped.cycle
        for name, value in stamped.state._asdict().items():
            setattr(msg, name, value)

    return Exchange(msg_type, fill, _only_published)


def _only_published(msg: Any) -> Any:
    raise TypeError(f"{type(msg).__name__}: no node of the bench reads this topic")


INPUTS = Exchange(BusInputsMsg, inputs_to_msg, inputs_from_msg)
COMMAND = Exchange(BusOutputs, command_to_msg, command_from_msg)
HUB = Exchange(HubState, hub_to_msg, hub_from_msg)
WRENCH = Exchange(WrenchStamped, wrench_to_msg, wrench_from_msg)
ENCODERS = Exchange(EncoderState, encoders_to_msg, encoders_from_msg)
ENCODER_JOINTS = Exchange(JointState, joints_of_encoders, _only_published)
REFERENCE = Exchange(ReferenceMsg, reference_to_msg, reference_from_msg)
DRIVE = Exchange(DriveStatus, drive_to_msg, drive_from_msg)
