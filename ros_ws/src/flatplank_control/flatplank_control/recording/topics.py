# SPDX-License-Identifier: Apache-2.0
"""Table of the topics that are recorded, for recorder, twin and documentation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from flatplank_control.recording.typestore import typestore
from flatplank_data.run_record import RunRecord
from flatplank_data.yaml_text import dump_yaml

_INFINITE_NS = 2**63 - 1


@dataclass(frozen=True)
class Qos:
    """Offered QoS profile, in the terms of `ros2 topic info --verbose` in lower case."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    history: str = "keep_last"
    deadline_ns: int = _INFINITE_NS
    """[ns]"""
    lifespan_ns: int = _INFINITE_NS
    """[ns]"""

    @property
    def latched(self) -> bool:
        """True when the last message holds until the next one."""
        return self.durability == "transient_local" and self.depth == 1


STREAM = Qos(depth=2000)
LATCHED = Qos(depth=1, durability="transient_local")
REFERENCE = Qos(depth=2000, deadline_ns=100_000_000)
HEALTH = Qos(depth=10)


class TopicSpec(NamedTuple):
    """A topic to record."""

    name: str
    type: str
    """package/msg/Type"""
    qos: Qos = STREAM


def _duration(ns: int) -> dict[str, int]:
    return {"sec": ns // 1_000_000_000, "nsec": ns % 1_000_000_000}


def qos_text(qos: Qos) -> str:
    """The offered profile as text for the metadata of an MCAP channel."""
    profile = {
        "history": qos.history,
        "depth": qos.depth,
        "reliability": qos.reliability,
        "durability": qos.durability,
        "deadline": _duration(qos.deadline_ns),
        "lifespan": _duration(qos.lifespan_ns),
        "liveliness": "automatic",
        "liveliness_lease_duration": _duration(_INFINITE_NS),
        "avoid_ros_namespace_conventions": False,
    }
    return dump_yaml([profile]).strip()


class BenchTopic(NamedTuple):
    """A row of the table of topics, docs/reference/graph.md."""

    spec: TopicSpec
    rate: str
    says: str
    modes: tuple[str, ...] = ()
    """operation modes of the wheel drive in which alone it is published, at every cycle"""


def _row(name: str, kind: str, rate: str, says: str, qos=STREAM, modes=()) -> BenchTopic:
    return BenchTopic(TopicSpec(name, kind, qos), rate, says, modes)


TABLE = (
    _row("/bus/inputs", "flatplank_msgs/msg/BusInputs", "cycle",
         "raw process image: bridge volts [V], counts, status words; one cycle or a batch"),
    _row("/bus/outputs", "flatplank_msgs/msg/BusOutputs", "cycle",
         "command of one axis: control word, mode, targets [counts, counts/s, 1e-4 N m]"),
    _row("/measurement_hub/wrench_wheel", "geometry_msgs/msg/WrenchStamped", "cycle",
         "forces [N], moments [N m] at the wheel centre"),
    _row("/measurement_hub/wrench_contact", "geometry_msgs/msg/WrenchStamped", "cycle",
         "the same at the contact point, ISO W"),
    _row("/measurement_hub/state", "flatplank_msgs/msg/HubState", "cycle",
         "loaded radius [m], total camber [rad], filter, saturation"),
    _row("/measurement_hub/joint_states", "sensor_msgs/msg/JointState", "cycle",
         "loaded radius [m] for standard tools"),
    _row("/encoders/state", "flatplank_msgs/msg/EncoderState", "cycle",
         "plank [m, m/s], wheel, motor [rad, rad/s], trigger, moving"),
    _row("/encoders/joint_states", "sensor_msgs/msg/JointState", "cycle",
         "plank [m], wheel, steer, road camber [rad] for standard tools"),
    _row("/wheel_drive/status", "flatplank_msgs/msg/DriveStatus", "cycle",
         "CiA 402 state, mode, actual and reference values, stop reason"),
    _row("/wheel_drive/joint_states", "sensor_msgs/msg/JointState", "cycle",
         "wheel by the motor encoder [rad, rad/s, N m at the motor]"),
    _row("/wheel_drive/reference", "flatplank_msgs/msg/Reference",
         "cycle, in slip and free rolling",
         "set-point of the active source [rad/s] or [N m]; deadline 100 ms", REFERENCE,
         ("slip", "free_rolling")),
    _row("/slip_sequencer/state", "flatplank_msgs/msg/SequencerState", "cycle, in slip",
         "reference and actual slip [-]", modes=("slip",)),
    _row("/free_rolling_controller/state", "flatplank_msgs/msg/ControllerState",
         "cycle, in free rolling", "error [N], p, i, lead, output [N m], settled",
         modes=("free_rolling",)),
    _row("/wheel_drive/mode", "flatplank_msgs/msg/OperationMode", "when it changes",
         "operation mode; stamp: last cycle before the drive follows it", LATCHED),
    _row("/slip_sequencer/waveform", "std_msgs/msg/String", "when it is set",
         "waveform with its parameters, where it starts, rolling radius (YAML)", LATCHED),
    _row("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "1 Hz",
         "every node with its troubles; published by the owner of the bus, with its times "
         "[us] and late cycles", HEALTH),
)  # fmt: skip
"""topics of every bench; the recorder adds those of `recorded_topics` and `/run`
(flatplank_msgs/Run), latched: the run record"""

RECORDED = tuple(row.spec for row in TABLE)


IN_CHARGE = TopicSpec("/operator/in_charge", "std_msgs/msg/String", LATCHED)
ROSOUT = TopicSpec(
    "/rosout",
    "rcl_interfaces/msg/Log",
    Qos(depth=1000, durability="transient_local", lifespan_ns=10_000_000_000),
)
"""log of all nodes, with the QoS of ROS; its stamps are of the wall clock"""

_OF_A_DRIVE = {
    "status": ("flatplank_msgs/msg/DriveStatus", STREAM),
    "joint_states": ("sensor_msgs/msg/JointState", STREAM),
    "reference": ("flatplank_msgs/msg/Reference", REFERENCE),
    "mode": ("flatplank_msgs/msg/OperationMode", LATCHED),
}


def recorded_topics(axes: Iterable[str]) -> tuple[TopicSpec, ...]:
    """All topics that the recorder takes; `axes`: driven beside the wheel."""
    of_axes = [
        TopicSpec(f"/{axis}_drive/{name}", kind, qos)
        for axis in axes
        for name, (kind, qos) in _OF_A_DRIVE.items()
        if axis != "plank" or name != "reference"  # nobody leads the plank's drive
    ]
    return (*RECORDED, *of_axes, IN_CHARGE, ROSOUT)


def at_every_cycle(mode: str) -> list[str]:
    """Topics published at every cycle in an operation mode of the wheel drive."""
    return [row.spec.name for row in TABLE if row.rate == "cycle" or mode in row.modes]


RUN_TOPIC = TopicSpec("/run", "flatplank_msgs/msg/Run", LATCHED)


def run_message(record: RunRecord, stamp_ns: int) -> bytes:
    """Serialised flatplank_msgs/Run; `stamp_ns` is the time of the bench [ns]."""
    store = typestore()
    make = store.types
    stamp = make["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 1_000_000_000))
    message = make[RUN_TOPIC.type](
        header=make["std_msgs/msg/Header"](stamp, ""),
        uuid=record.uuid,
        name=record.name,
        status=record.status,
        record=record.to_yaml(),
    )
    return bytes(store.serialize_cdr(message, RUN_TOPIC.type))
