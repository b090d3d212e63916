# SPDX-License-Identifier: Apache-2.0
"""Messages to the tuples of the cores and back. Values pass through unchanged."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from struct import Struct

from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Header

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs
from flatplank_hw.drive import REASONS
from flatplank_hw.samples import (
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

NO_WRENCH = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
CHANNELS = 6
_AXES = len(AXES)
_STAMP = Struct("<iI")


def set_stamp(header: Header, stamp_ns: int) -> None:
    header.stamp.sec, header.stamp.nanosec = divmod(stamp_ns, 1_000_000_000)


def stamp_ns(header: Header) -> int:
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def raw_stamp_ns(cdr: bytes) -> int:
    """Of a serialised message that begins with a header."""
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
    msg.lvdt_volts = array("d", [s.lvdt_volts for s in batch])
    msg.plank_counts = array("i", [s.plank_counts for s in batch])
    msg.wheel_counts = array("i", [s.wheel_counts for s in batch])
    msg.steer_counts = array("i", [s.steer_counts for s in batch])
    msg.camber_counts = array("i", [s.camber_counts for s in batch])
    msg.road_counts = array("i", [s.road_counts for s in batch])
    msg.digital = array("B", [s.digital for s in batch])
    axes = [axis for s in batch for axis in s.axes]
    msg.status_word = array("H", [a.status_word for a in axes])
    msg.mode_display = array("b", [a.mode_display for a in axes])
    msg.position = array("i", [a.position for a in axes])
    msg.velocity = array("i", [a.velocity for a in axes])
    msg.torque = array("i", [a.torque for a in axes])
    msg.error_code = array("H", [a.error_code for a in axes])


def inputs_from_msg(msg: BusInputsMsg) -> list[BusInputs]:
    """The cycles of a batch, oldest first."""
    n = msg.count
    stamp = stamp_ns(msg.header)
    axes = [
        AxisInputs(*row)
        for row in zip(
            msg.status_word, msg.mode_display, msg.position, msg.velocity, msg.torque,
            msg.error_code, strict=True,
        )
    ]  # fmt: skip
    volts = msg.bridge_volts
    return [
        BusInputs(
            msg.cycle - (n - 1 - k),
            stamp - (n - 1 - k) * msg.period_ns,
            tuple(volts[CHANNELS * k : CHANNELS * (k + 1)]),
            msg.lvdt_volts[k],
            msg.plank_counts[k],
            msg.wheel_counts[k],
            msg.steer_counts[k],
            msg.camber_counts[k],
            msg.road_counts[k],
            msg.digital[k],
            msg.health,
            tuple(axes[_AXES * k : _AXES * (k + 1)]),
        )
        for k in range(n)
    ]


def command_to_msg(command: AxisCommand, stamp: int, msg: BusOutputs) -> None:
    set_stamp(msg.header, stamp)
    (msg.axis, msg.cycle, msg.control_word, msg.mode, msg.target_position, msg.target_velocity,
     msg.target_torque, msg.digital_outputs) = command  # fmt: skip


def command_from_msg(msg: BusOutputs) -> AxisCommand:
    return AxisCommand(
        msg.axis, msg.cycle, msg.control_word, msg.mode, msg.target_position, msg.target_velocity,
        msg.target_torque, msg.digital_outputs,
    )  # fmt: skip


def wrench_to_msg(wrench: Wrench, stamp: int, msg: WrenchStamped) -> None:
    set_stamp(msg.header, stamp)
    force, torque = msg.wrench.force, msg.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = wrench


def wrench_from_msg(msg: WrenchStamped) -> Wrench:
    force, torque = msg.wrench.force, msg.wrench.torque
    return Wrench(force.x, force.y, force.z, torque.x, torque.y, torque.z)


def hub_to_msg(sample: HubSample, msg: HubState) -> None:
    set_stamp(msg.header, sample.stamp_ns)
    msg.cycle, msg.loaded_radius = sample.cycle, sample.loaded_radius
    msg.total_camber, msg.fz_filtered = sample.total_camber, sample.fz_filtered
    msg.filter_on, msg.saturated = sample.filter_on, sample.saturated


def hub_from_msg(msg: HubState) -> HubSample:
    """The state alone: the wrenches travel on topics of their own and are zero here."""
    return HubSample(
        msg.cycle, stamp_ns(msg.header), NO_WRENCH, NO_WRENCH, msg.loaded_radius, msg.total_camber,
        msg.fz_filtered, msg.filter_on, msg.saturated,
    )  # fmt: skip


def hub_of_contact(contact: Wrench, encoders: EncoderSample) -> HubSample:
    """The contact wrench alone, for the free-rolling controller."""
    return HubSample(
        encoders.cycle,
        encoders.stamp_ns,
        NO_WRENCH,
        contact,
        math.nan,
        math.nan,
        math.nan,
        False,
        0,
    )


def encoders_to_msg(sample: EncoderSample, msg: EncoderState) -> None:
    set_stamp(msg.header, sample.stamp_ns)
    (msg.cycle, _, msg.plank_position, msg.plank_velocity, msg.wheel_angle, msg.wheel_velocity,
     msg.steer_angle, msg.road_camber, msg.road_position, msg.motor_angle, msg.motor_velocity,
     msg.plank_moving, msg.trigger, msg.mismatch) = sample  # fmt: skip


def encoders_from_msg(msg: EncoderState) -> EncoderSample:
    return EncoderSample(
        msg.cycle, stamp_ns(msg.header), msg.plank_position, msg.plank_velocity, msg.wheel_angle,
        msg.wheel_velocity, msg.steer_angle, msg.road_camber, msg.road_position, msg.motor_angle,
        msg.motor_velocity, msg.plank_moving, msg.trigger, msg.mismatch,
    )  # fmt: skip


def reference_to_msg(reference: Reference, msg: ReferenceMsg) -> None:
    set_stamp(msg.header, reference.stamp_ns)
    msg.cycle, msg.source = reference.cycle, SOURCES.index(reference.source)
    msg.value, msg.valid = reference.value, reference.valid


def reference_from_msg(msg: ReferenceMsg) -> Reference:
    return Reference(msg.cycle, stamp_ns(msg.header), SOURCES[msg.source], msg.value, msg.valid)


def drive_to_msg(sample: DriveSample, msg: DriveStatus) -> None:
    set_stamp(msg.header, sample.stamp_ns)
    (msg.cycle, _, msg.state, msg.mode, msg.position, msg.velocity, msg.torque,
     msg.reference_position, msg.reference_velocity, msg.reference_torque, msg.stop_reason,
     msg.error_code) = sample  # fmt: skip
    msg.stop_text = REASONS[sample.stop_reason]


def drive_from_msg(msg: DriveStatus) -> DriveSample:
    return DriveSample(
        msg.cycle, stamp_ns(msg.header), msg.state, msg.mode, msg.position, msg.velocity,
        msg.torque, msg.reference_position, msg.reference_velocity, msg.reference_torque,
        msg.stop_reason, msg.error_code,
    )  # fmt: skip
