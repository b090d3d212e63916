# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench that go into a bag: one table for recorder, twin and documentation."""

from __future__ import annotations

from typing import NamedTuple

from flatplank_control.recording import TopicSpec
from flatplank_control.recording.qos import HEALTH, LATCHED, REFERENCE, STREAM


class BenchTopic(NamedTuple):
    """A row of the table in ARCHITECTURE.md."""

    spec: TopicSpec
    rate: str
    says: str
    modes: tuple[str, ...] = ()
    """operation modes of the wheel drive in which it speaks at every cycle, and only in them"""


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
    _row("/wheel_drive/mode", "std_msgs/msg/String", "when it changes", "operation mode", LATCHED),
    _row("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "1 Hz",
         "health of the nodes", HEALTH),
)  # fmt: skip
"""Beside these the recorder itself says `/run` (flatplank_msgs/Run), latched: the run record."""

RECORDED = tuple(row.spec for row in TABLE)


def at_every_cycle(mode: str) -> list[str]:
    """Topics that speak at every cycle in an operation mode of the wheel drive."""
    return [row.spec.name for row in TABLE if row.rate == "cycle" or mode in row.modes]
