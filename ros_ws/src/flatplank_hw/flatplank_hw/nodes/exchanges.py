# SPDX-License-Identifier: Apache-2.0
"""Exchanges: how the samples of each topic become serialised messages and samples again."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState

from flatplank_hw.bus.image import AXES, CHANNELS, PER_CYCLE, AxisInputs
from flatplank_hw.drive import REASONS
from flatplank_hw.nodes.convert import (
    Batch,
    StampedWrench,
    command_from_msg,
    drive_from_msg,
    encoders_from_msg,
    hub_from_msg,
    inputs_from_msg,
    mode_from_msg,
    reference_from_msg,
    wrench_from_msg,
)
from flatplank_hw.nodes.packing import pack_like
from flatplank_hw.samples import JOINTS, RADIUS_JOINT, SOURCES, EncoderSample, Reference
from flatplank_msgs.msg import (
    BusInputs,
    BusOutputs,
    DriveStatus,
    EncoderState,
    HubState,
    OperationMode,
)
from flatplank_msgs.msg import Reference as ReferenceMsg

_BY_CYCLE = attrgetter(*PER_CYCLE)


class Exchange(NamedTuple):
    """How the samples of a topic become messages and samples again."""

    msg_type: type
    numbers: Callable[[Any], Sequence[float]]
    """sample -> all numbers of its message, in the order of the definition"""
    read: Callable[[Any], Any]
    """message -> sample"""
    shape: Callable[[Any], Hashable] = lambda _sample: None
    """sample -> what determines the texts and sequence lengths of its message"""
    prepare: Callable[[Any, Any], None] = lambda _shape, _message: None
    """`prepare(shape, message)` gives a new message these texts and lengths"""

    def packing(self, frame: str) -> Callable[[Any], bytes]:
        """Function that serialises samples; `frame`: frame id of the messages."""
        packs: dict[Hashable, Callable[[Sequence[float]], bytes]] = {}
        shape_of, numbers_of = self.shape, self.numbers

        def pack(sample: Any) -> bytes:
            shape = shape_of(sample)
            if shape not in packs:
                example = self.msg_type()
                example.header.frame_id = frame
                self.prepare(shape, example)
                packs[shape] = pack_like(example)
            return packs[shape](numbers_of(sample))

        return pack


def _seconds(stamp_ns: int) -> tuple[int, int]:
    """Numbers of a stamp."""
    return divmod(stamp_ns, 1_000_000_000)


def inputs_numbers(batch: Batch) -> list[float]:
    cycles, period_ns = batch
    last = cycles[-1]
    head = (*_seconds(last.stamp_ns), last.cycle, period_ns, len(cycles), last.health)
    numbers: list[float] = [*head, *(v for s in cycles for v in s.bridge_volts)]
    for column in zip(*map(_BY_CYCLE, cycles), strict=True):
        numbers += column
    for column in zip(*[axis for s in cycles for axis in s.axes], strict=True):
        numbers += column
    return numbers


def prepare_inputs(count: int, msg: BusInputs) -> None:
    """Give the arrays of a message the lengths for `count` cycles."""
    lengths = {
        "bridge_volts": CHANNELS, **dict.fromkeys(PER_CYCLE, 1),
        **dict.fromkeys(AxisInputs._fields, len(AXES)),
    }  # fmt: skip
    for name, length in lengths.items():
        getattr(msg, name).extend([0] * (count * length))


def _fields_of(msg_type: Any, without: str = "") -> tuple[str, ...]:
    """Fields of a message behind its header, in the order of the definition."""
    names: list[str] = list(msg_type.get_fields_and_field_types())
    return tuple(name for name in names[1:] if name != without)


def _numbers_of(
    msg_type: Any, without: str = "", of: Callable[[Any], Any] = lambda sample: sample
) -> Callable[[Any], Sequence[float]]:
    """Function that gives the numbers of a message whose fields are named as those `of` the
    sample; `without`: a field of the message that is no number."""
    fields = attrgetter(*_fields_of(msg_type, without))
    return lambda sample: (*_seconds(sample.stamp_ns), *fields(of(sample)))


def wrench_numbers(stamped: StampedWrench) -> Sequence[float]:
    return (*_seconds(stamped.stamp_ns), *stamped.wrench)


def reference_numbers(reference: Reference) -> Sequence[float]:
    source = SOURCES.index(reference.source)
    stamp = _seconds(reference.stamp_ns)
    return (*stamp, reference.cycle, source, reference.value, reference.valid)


def prepare_drive(stop_reason: int, msg: DriveStatus) -> None:
    msg.stop_text = REASONS[stop_reason]


def prepare_mode(mode: str, msg: OperationMode) -> None:
    msg.mode = mode


def joint_numbers(sample: EncoderSample) -> Sequence[float]:
    """Plank [m], wheel, steering and road camber angle [rad]."""
    angles = sample.wheel_angle, sample.steer_angle, sample.road_camber
    velocities = sample.plank_velocity, sample.wheel_velocity, 0.0, 0.0
    return (*_seconds(sample.stamp_ns), sample.plank_position, *angles, *velocities)


def _joints(
    names: Sequence[str], numbers: Callable[[Any], Sequence[float]], *arrays: str
) -> Exchange:
    """Exchange with the joint states of `names`; `arrays` of the message have their values."""

    def prepare(_shape: Hashable, msg: JointState) -> None:
        msg.name = list(names)
        for array in arrays:
            getattr(msg, array).extend([0.0] * len(names))

    return Exchange(JointState, numbers, _only_published, prepare=prepare)


def joint_of_axis(axis: str) -> Exchange:
    """Exchange of drive samples with the joint state of one axis by its motor encoder."""
    return _joints(
        (axis,), lambda s: (*_seconds(s.stamp_ns), s.position, s.velocity, s.torque),
        "position", "velocity", "effort",
    )  # fmt: skip


def state_exchange(msg_type: Any) -> Exchange:
    """Exchange of the state of a source of references."""
    state = attrgetter(*_fields_of(msg_type, without="cycle"))
    return Exchange(
        msg_type, lambda s: (*_seconds(s.stamp_ns), s.cycle, *state(s.state)), _only_published
    )


def _only_published(msg: Any) -> Any:
    raise TypeError(f"{type(msg).__name__}: no node of the bench reads this topic")


INPUTS = Exchange(
    BusInputs, inputs_numbers, inputs_from_msg, lambda batch: len(batch.cycles), prepare_inputs
)
COMMAND = Exchange(BusOutputs, _numbers_of(BusOutputs, of=attrgetter("command")), command_from_msg)
HUB = Exchange(HubState, _numbers_of(HubState), hub_from_msg)
WRENCH = Exchange(WrenchStamped, wrench_numbers, wrench_from_msg)
ENCODERS = Exchange(EncoderState, _numbers_of(EncoderState), encoders_from_msg)
ENCODER_JOINTS = _joints(JOINTS, joint_numbers, "position", "velocity")
HUB_JOINTS = _joints(
    (RADIUS_JOINT,), lambda s: (*_seconds(s.stamp_ns), s.loaded_radius), "position"
)
REFERENCE = Exchange(ReferenceMsg, reference_numbers, reference_from_msg)
MODE = Exchange(
    OperationMode, lambda s: _seconds(s.stamp_ns), mode_from_msg, attrgetter("mode"), prepare_mode
)
DRIVE = Exchange(
    DriveStatus, _numbers_of(DriveStatus, without="stop_text"), drive_from_msg,
    attrgetter("stop_reason"), prepare_drive,
)  # fmt: skip
