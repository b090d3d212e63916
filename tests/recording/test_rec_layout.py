# SPDX-License-Identifier: Apache-2.0
"""Fixed CDR layouts against two independent serialisers."""

from __future__ import annotations

import importlib
import importlib.util
import json
import random
import warnings

import numpy as np
import pytest
from rec_samples import one_by_one
from rosbags.interfaces import Nodetype

from flatplank_control.recording.cdr_layout import CdrLayout
from flatplank_control.recording.typestore import message_folder, type_hash, typestore
from flatplank_data.errors import RecordingError

OWN = [f"flatplank_msgs/msg/{path.stem}" for path in sorted(message_folder().glob("*.msg"))]
STANDARD = [
    "sensor_msgs/msg/JointState",
    "geometry_msgs/msg/WrenchStamped",
    "std_msgs/msg/String",
    "std_msgs/msg/Empty",
    "diagnostic_msgs/msg/DiagnosticArray",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/PointCloud2",
]


def random_fixed(msgtype: str, rng: random.Random, prefix: str = "") -> dict:
    """Texts and lengths for all that may vary; empty ones too."""
    fixed: dict = {}
    for name, (node, detail) in typestore().fielddefs[msgtype][1]:
        path = prefix + name
        if node == Nodetype.BASE and detail[0] == "string":
            fixed[path] = "x" * rng.randrange(6)
        elif node == Nodetype.NAME:
            fixed |= random_fixed(detail, rng, path + ".")
        elif node == Nodetype.SEQUENCE:
            kind, of = detail[0]
            count = rng.randrange(4)
            if kind == Nodetype.BASE and of[0] == "string":
                fixed[path] = ["y" * rng.randrange(6) for _ in range(count)]
                continue
            fixed[path] = count
            if kind == Nodetype.NAME:
                for number in range(count):
                    fixed |= random_fixed(of, rng, f"{path}[{number}].")
    return fixed


def random_rows(layout: CdrLayout, rng: np.random.Generator, count: int = 3) -> np.ndarray:
    rows = layout.new(count)
    for name in layout.dtype.names or ():
        column = rows[name]
        if column.dtype == bool:
            rows[name] = rng.integers(0, 2, column.shape)
        elif column.dtype.kind == "f":
            rows[name] = rng.normal(size=column.shape)
        else:
            limits = np.iinfo(column.dtype)
            rows[name] = rng.integers(limits.min, limits.max, column.shape, dtype=column.dtype)
    return rows


@pytest.mark.parametrize("msgtype", OWN + STANDARD)
def test_same_bytes_as_rosbags(msgtype):
    store = typestore()
    for seed in range(10):
        layout = CdrLayout(msgtype, random_fixed(msgtype, random.Random(seed)))
        for data in one_by_one(random_rows(layout, np.random.default_rng(seed))):
            message = store.deserialize_cdr(data, msgtype)
            assert bytes(store.serialize_cdr(message, msgtype, little_endian=True)) == data


def python_classes() -> dict[str, type]:
    """Message classes of ROS that are here; without ROS there are none."""
    classes = {}
    for name in OWN + STANDARD:
        package, _, kind = name.split("/")
        if importlib.util.find_spec("rclpy") and importlib.util.find_spec(package):
            found = getattr(importlib.import_module(f"{package}.msg"), kind)
            with warnings.catch_warnings():  # of the parser that comes with the type support
                warnings.simplefilter("ignore", DeprecationWarning)
                type(found).__import_type_support__()
            classes[name] = found
    return classes


def used_bytes(layout: CdrLayout) -> np.ndarray:
    """bool [itemsize]: False where the format only pads."""
    used: np.ndarray = np.zeros(layout.itemsize, bool)
    for offset, data in layout._constants:
        used[offset : offset + len(data)] = True
    for form, offset in layout.dtype.fields.values():
        used[offset : offset + form.itemsize] = True
    return used


def test_same_bytes_as_rclpy():
    """But for what Fast-CDR leaves as it finds it: padding, and spare bytes at the end."""
    for msgtype, kind in python_classes().items():
        serialization = importlib.import_module("rclpy.serialization")
        for seed in range(10):
            layout = CdrLayout(msgtype, random_fixed(msgtype, random.Random(seed)))
            used = used_bytes(layout)
            for data in one_by_one(random_rows(layout, np.random.default_rng(seed))):
                message = serialization.deserialize_message(data, kind)
                theirs = serialization.serialize_message(message)
                assert len(data) <= len(theirs)
                ours = np.frombuffer(data, np.uint8)
                same = ours == np.frombuffer(theirs, np.uint8)[: len(data)]
                assert same[used].all(), msgtype


def test_hashes_of_our_types_are_those_of_the_build():
    """The build writes a JSON description of each type beside the installed .msg file."""
    for path in message_folder().glob("*.json"):
        hashes = json.loads(path.read_text())["type_hashes"]
        built = {entry["type_name"]: entry["hash_string"] for entry in hashes}
        name = f"flatplank_msgs/msg/{path.stem}"
        assert type_hash(name) == built[name]


def test_what_is_fixed_must_be_there():
    with pytest.raises(RecordingError, match=r"header\.frameid.*header\.frame_id"):
        CdrLayout("sensor_msgs/msg/JointState", {"header.frameid": "x"})
    with pytest.raises(RecordingError, match="position needs int"):
        CdrLayout("sensor_msgs/msg/JointState", {"position": "x"})
    with pytest.raises(RecordingError, match="unknown message type"):
        CdrLayout("no_msgs/msg/Such")


def test_padding_is_zero():
    layout = CdrLayout("sensor_msgs/msg/JointState", {"name": ["a"], "position": 1})
    raw = layout.new(2).view(np.uint8).reshape(2, -1)
    assert not raw[:, ~used_bytes(layout)].any()
