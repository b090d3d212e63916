# SPDX-License-Identifier: Apache-2.0
"""Writes bags as rosbag2 does, from the message files of the source tree."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flatplank_hw.drive import REASONS

SEQUENCER = "flatplank_msgs/msg/SequencerState"
CONTROLLER = "flatplank_msgs/msg/ControllerState"
MSG = Path(__file__).resolve().parents[2] / "ros_ws/src/flatplank_msgs/msg"


def store():
    types = {}
    for path in sorted(MSG.glob("*.msg")):
        types |= get_types_from_msg(path.read_text(), f"flatplank_msgs/msg/{path.stem}")
    found = get_typestore(Stores.ROS2_JAZZY)
    found.register(types)
    return found


class Bag:
    """One MCAP file; `write(topic, type, stamp_ns, fields)`."""

    def __init__(
        self, folder: Path, compression: CompressionType = CompressionType.NONE, **options
    ):
        folder.mkdir(parents=True)
        self.types = store()
        self.stream = (folder / f"{folder.name}_0.mcap").open("wb")
        self.writer = Writer(self.stream, compression=compression, **options)
        self.writer.start(profile="ros2")
        self.channels: dict[str, int] = {}

    def close(self) -> None:
        self.writer.finish()
        self.stream.close()

    def channel(self, topic: str, kind: str) -> int:
        if topic not in self.channels:
            text = self.types.generate_msgdef(kind, ros_version=2)[0]
            schema = self.writer.register_schema(kind, "ros2msg", text.encode())
            self.channels[topic] = self.writer.register_channel(topic, "cdr", schema)
        return self.channels[topic]

    def header(self, stamp: int, frame: str = ""):
        t = self.types.types
        time = t["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
        return t["std_msgs/msg/Header"](stamp=time, frame_id=frame)

    def write(self, topic: str, kind: str, stamp: int, message) -> None:
        data = bytes(self.types.serialize_cdr(message, kind))
        self.writer.add_message(self.channel(topic, kind), stamp, data, stamp)


def wrench(bag: Bag, stamp: int, values, frame: str = "contact"):
    t = bag.types.types
    vector = t["geometry_msgs/msg/Vector3"]
    force, torque = vector(*values[:3]), vector(*values[3:])
    return t["geometry_msgs/msg/WrenchStamped"](
        header=bag.header(stamp, frame), wrench=t["geometry_msgs/msg/Wrench"](force, torque)
    )


def write_run(
    folder: Path, columns: dict[str, np.ndarray], record: str, name: str = "", **options
):
    """A bench bag with the topics that the analysis reads; time in s.

    The slip control speaks in runs with a column slip_reference, free rolling in those with
    controller_error; the drive is enabled unless drive_state and stop_reason say otherwise.
    """
    bag = Bag(folder, **options)
    types = bag.types.types

    def tell(status: str, stamp: int) -> None:
        kind = "flatplank_msgs/msg/Run"
        run = types[kind](bag.header(stamp), "u-" + folder.name, name, status, record)
        bag.write("/run", kind, stamp, run)

    tell("armed", 0)
    encoder = types["flatplank_msgs/msg/EncoderState"]
    hub = types["flatplank_msgs/msg/HubState"]
    drive = types["flatplank_msgs/msg/DriveStatus"]
    sequencer, controller = types[SEQUENCER], types[CONTROLLER]
    for i, time in enumerate(columns["time"]):
        stamp = round(float(time) * 1e9) + 5 * 10**9
        c = {k: float(v[i]) for k, v in columns.items()}
        head = bag.header(stamp)
        message = encoder(
            head,
            i,
            c["plank_position"],
            c["plank_velocity"],
            c["wheel_angle"],
            c["wheel_velocity"],
            0.0,
            0.0,
            float("nan"),
            0.0,
            c["motor_velocity"],
            True,
            True,
            0.0,
        )
        bag.write("/encoders/state", "flatplank_msgs/msg/EncoderState", stamp, message)
        forces = [c[k] for k in ("fx", "fy", "fz", "mx", "my", "mz")]
        kind = "geometry_msgs/msg/WrenchStamped"
        bag.write("/measurement_hub/wrench_contact", kind, stamp, wrench(bag, stamp, forces))
        message = hub(head, i, c["loaded_radius"], 0.0, c["fz"], True, 0)
        bag.write("/measurement_hub/state", "flatplank_msgs/msg/HubState", stamp, message)
        message = drive(
            bag.header(stamp, "wheel"),
            i,
            int(c.get("drive_state", 4)),
            0,
            0.0,
            0.0,
            c["motor_torque"],
            0.0,
            0.0,
            0.0,
            int(c.get("stop_reason", 0)),
            0,
            REASONS[int(c.get("stop_reason", 0))],
        )
        bag.write("/wheel_drive/status", "flatplank_msgs/msg/DriveStatus", stamp, message)
        if "slip_reference" in c:
            asked = c["slip_reference"]
            numbers = (asked, asked, c["wheel_velocity"], 0.0, c["slip_start"], c["slip_radius"])
            message = sequencer(head, i, True, *numbers)
            bag.write("/slip_sequencer/state", SEQUENCER, stamp, message)
        if "controller_error" in c:
            numbers = (50.0, c["controller_error"], 0.0, 0.0, 0.0, 0.0)
            message = controller(head, i, *numbers, False, True)
            bag.write("/free_rolling_controller/state", CONTROLLER, stamp, message)
    end = float(columns["time"][-1]) if len(columns["time"]) else 0.0
    tell("complete", round(end * 1e9) + 5 * 10**9)
    bag.close()
