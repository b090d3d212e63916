# SPDX-License-Identifier: Apache-2.0
"""Messages and bags for the tests of the recording."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader

from flatplank_control.recording.blocks import TopicBlock, unroll
from flatplank_control.recording.cdr_layout import CdrLayout, set_stamps
from flatplank_control.recording.topics import LATCHED, TopicSpec
from flatplank_control.recording.typestore import typestore
from flatplank_data.run_record import RunRecord, record_from_dict

PERIOD_NS = 4_000_000
BUS = "/bus/inputs"
WRENCH = "/measurement_hub/wrench_contact"
MODE = "/wheel_drive/mode"
TOPICS = [
    TopicSpec(BUS, "flatplank_msgs/msg/BusInputs"),
    TopicSpec(WRENCH, "geometry_msgs/msg/WrenchStamped"),
    TopicSpec(MODE, "flatplank_msgs/msg/OperationMode", LATCHED),
]


@cache
def bus_layout(batch: int = 1) -> CdrLayout:
    """BusInputs with `batch` cycles per message."""
    single = ("lvdt_volts", "plank_counts", "wheel_counts", "steer_counts", "camber_counts")
    drives = ("status_word", "mode_display", "position", "velocity", "torque", "error_code")
    lengths = {name: batch for name in (*single, "road_counts", "digital")}
    lengths |= {name: 5 * batch for name in drives}
    fixed = {"header.frame_id": "bus", "bridge_volts": 6 * batch, **lengths}
    return CdrLayout("flatplank_msgs/msg/BusInputs", fixed)


@cache
def wrench_layout() -> CdrLayout:
    return CdrLayout("geometry_msgs/msg/WrenchStamped", {"header.frame_id": "contact"})


def bus_messages(
    cycles, trigger_from: int | None = None, batch: int = 1, since_ns: int = 0
) -> np.ndarray:
    """One message per entry of `cycles`, the last cycle of each batch; cycle 0 at `since_ns`."""
    cycles = np.asarray(cycles, np.int64)
    messages = bus_layout(batch).new(len(cycles))
    set_stamps(messages, since_ns + cycles * PERIOD_NS)
    messages["period_ns"] = PERIOD_NS
    messages["cycle"] = cycles
    messages["count"] = batch
    if trigger_from is not None:
        messages["digital"] = np.uint8(1) * (cycles[:, None] >= trigger_from)
    return messages


def one_by_one(messages: np.ndarray) -> list[bytes]:
    block = TopicBlock("", np.arange(len(messages)), messages)
    return [data for _, data, _ in unroll([block])]


def bus_bytes(cycle: int, trigger: bool = False, batch: int = 1, since_ns: int = 0) -> bytes:
    return bus_messages([cycle], cycle if trigger else None, batch, since_ns).tobytes()


def wrench_bytes(fx: float) -> bytes:
    message = wrench_layout().new(1)
    message["wrench.force.x"] = fx
    return message.tobytes()


def mode_bytes(mode: str) -> bytes:
    store = typestore()
    kinds = store.types
    stamp = kinds["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="wheel")
    message = kinds["flatplank_msgs/msg/OperationMode"](header=header, mode=mode)
    return bytes(store.serialize_cdr(message, "flatplank_msgs/msg/OperationMode"))


def toyo(**changes) -> RunRecord:
    """TOY_REL_LNG_5perc_T_p25_Fz5550_2"""
    values = {"tire": "TOY", "kappa": 0.05, "fz": 5550.0, "pressure": 2.5, "start": 2}
    return record_from_dict(values | changes)


def read(path: Path) -> list[tuple[str, int, bytes]]:
    """All messages of a bag: topic, stamp [ns], CDR."""
    with AnyReader([path]) as reader:
        return [(c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages()]
