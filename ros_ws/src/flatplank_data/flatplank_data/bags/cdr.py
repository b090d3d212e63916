# SPDX-License-Identifier: Apache-2.0
"""Converts CDR payloads to columns: one layout serves many payloads, read as one numpy view.

Plain CDR (XCDR1), as ROS 2 writes it: four bytes of encapsulation, then members aligned to their
size. A length precedes each text and sequence; payloads with the same lengths share a layout. The
members come from the message definition (`.msg` text), which a bag contains.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from flatplank_data.errors import FlatplankError

PRIMITIVES = {
    "bool": "u1",
    "byte": "u1",
    "char": "u1",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}

#: standard types, for bags that were written without definitions
STANDARD = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/Float64": "float64 data",
    "std_msgs/Float32": "float32 data",
    "std_msgs/String": "string data",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
}

_FIELD = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?P<array>\[[^\]]*\])?\s+(?P<name>\w+)\s*(?P<rest>.*)$"
)


@dataclass(frozen=True)
class Field:
    """One member of a message; `count` 1 single, n fixed array, 0 sequence."""

    name: str
    type: str
    array: bool
    count: int


@dataclass(frozen=True)
class MessageType:
    """Fields of a type and of all its member types, by short name (`pkg/Name`)."""

    name: str
    types: dict[str, tuple[Field, ...]]

    def fields(self, name: str) -> tuple[Field, ...]:
        """Fields of one of the types."""
        short = short_name(name)
        if short not in self.types:
            raise FlatplankError(
                f"the bag has no definition of {name}", self.name, "record it with definitions"
            )
        return self.types[short]


def short_name(name: str) -> str:
    """`pkg/Name` of `pkg/msg/Name`."""
    parts = name.split("/")
    return f"{parts[0]}/{parts[-1]}" if len(parts) > 1 else name


@lru_cache(maxsize=256)
def parse_definition(name: str, text: str) -> MessageType:
    """Type `name` from the text that MCAP calls `ros2msg`."""
    sections = re.split(r"^=+\s*$", text, flags=re.MULTILINE)
    types: dict[str, tuple[Field, ...]] = {}
    if sections[0].strip():
        types[short_name(name)] = _fields(sections[0], name)
    for section in sections[1:]:
        head, _, body = section.strip().partition("\n")
        part = short_name(head.removeprefix("MSG:").strip())
        types[part] = _fields(body, part)
    for part, body in STANDARD.items():
        types.setdefault(part, _fields(body, part))
    return MessageType(short_name(name), types)


def _fields(body: str, owner: str) -> tuple[Field, ...]:
    package = owner.split("/")[0]
    out = []
    for line in body.splitlines():
        match = _FIELD.match(line.split("#", 1)[0].strip())
        if match is None or match["rest"].startswith("="):
            continue
        kind = match["type"]
        if kind not in PRIMITIVES and kind not in ("string", "wstring") and "/" not in kind:
            kind = "std_msgs/Header" if kind == "Header" else f"{package}/{kind}"
        array = match["array"] or ""
        bound = array.strip("[]")
        count = int(bound) if bound.isdigit() else (0 if array else 1)
        out.append(Field(match["name"], kind, bool(array), count))
    return tuple(out)


_START = 4
NAMES = re.compile(r"(?:.*\.)?(?:name|names|joint_names)\[\d+\]")
"""paths of names that say what the elements of the arrays beside them are, as in JointState"""


@dataclass
class Layout:
    """Where each member lies in a payload of `size` bytes."""

    size: int
    order: str
    members: dict[str, tuple[str, int]] = field(default_factory=dict)
    """path -> (numpy type, offset)"""
    texts: dict[str, tuple[int, int]] = field(default_factory=dict)
    """path -> (offset, length without the terminating zero [bytes])"""
    lengths: list[tuple[int, int]] = field(default_factory=list)
    """(offset, value) of each length word; equal in all payloads of this layout"""


class _Walk:
    """Finds the offset of every member of one payload."""

    def __init__(self, kind: MessageType, payload: bytes) -> None:
        if len(payload) < _START or payload[0] != 0 or payload[1] not in (0, 1):
            raise FlatplankError("payload is not plain CDR", kind.name, "record it with rosbag2")
        self.kind, self.payload, self.at = kind, payload, _START
        self.order = "<" if payload[1] == 1 else ">"
        self.layout = Layout(len(payload), self.order)

    def message(self, name: str, prefix: str) -> None:
        for item in self.kind.fields(name):
            path = prefix + item.name
            count = item.count
            if item.array and not item.count:
                count = self.length()
            if count > len(self.payload):  # also of members that take no bytes
                raise FlatplankError("payload is cut short", path, "the bag is damaged")
            for i in range(count):
                self.member(item.type, f"{path}[{i}]" if item.array else path)

    def member(self, kind: str, path: str) -> None:
        if kind in PRIMITIVES:
            code = PRIMITIVES[kind]
            size = int(code[1])
            self.at += (_START - self.at) % size
            self.layout.members[path] = (self.order + code, self.at)
            self.at += size
        elif kind == "string":
            size = self.length()
            self.layout.texts[path] = (self.at, max(size - 1, 0))
            self.at += size
        elif kind == "wstring":
            raise FlatplankError("wide strings are not read", path, "map other topics")
        else:
            self.message(kind, path + ".")
        if self.at > len(self.payload):
            raise FlatplankError("payload is cut short", path, "the bag is damaged")

    def length(self) -> int:
        self.at += (_START - self.at) % 4
        if self.at + 4 > len(self.payload):
            raise FlatplankError("payload is cut short", self.kind.name, "the bag is damaged")
        (value,) = struct.unpack_from(self.order + "I", self.payload, self.at)
        self.layout.lengths.append((self.at, value))
        self.at += 4
        return value


def layout_of(kind: MessageType, payload: bytes) -> Layout:
    """Layout of all payloads whose texts and sequences have the same lengths as in this one."""
    walk = _Walk(kind, payload)
    walk.message(kind.name, "")
    return walk.layout


def decode_one(kind: MessageType, payload: bytes) -> dict[str, float | str]:
    """All members of one message by path."""
    layout = layout_of(kind, payload)
    out: dict[str, float | str] = {}
    for path, (code, at) in layout.members.items():
        out[path] = np.frombuffer(payload, dtype=code, count=1, offset=at)[0].item()
    for path, (at, size) in layout.texts.items():
        out[path] = payload[at : at + size].decode("utf-8", "replace")
    return out


@dataclass(frozen=True)
class Group:
    """Messages of one layout: their rows in the block, and their members."""

    rows: np.ndarray
    layout: Layout
    columns: dict[str, np.ndarray]
    names: dict[str, list[str]]
    """path of a list of names -> the names, the same in all messages of the group"""


def decode_groups(
    kind: MessageType, payloads: np.ndarray, wanted: Callable[[Layout], Iterable[str]]
) -> Iterator[Group]:
    """Members of payloads, a uint8 array of shape (messages, bytes), group by group.

    Payloads of a group have the same lengths of texts and sequences and the same lists of names.
    `wanted` gives the paths to read from a layout. Raises FlatplankError.
    """
    rest = np.arange(len(payloads))
    while rest.size:
        first = payloads[rest[0]].tobytes()
        layout = layout_of(kind, first)
        same = _equal(payloads, rest, first, 0, 2)
        for at, _ in layout.lengths:
            same &= _equal(payloads, rest, first, at, 4)
        named = {p: v for p, v in layout.texts.items() if NAMES.fullmatch(p)}
        for at, size in named.values():
            same &= _equal(payloads, rest, first, at, size)
        names: dict[str, list[str]] = {}
        for path, (at, size) in named.items():
            text = first[at : at + size].decode("utf-8", "replace")
            names.setdefault(path.rpartition("[")[0], []).append(text)
        chosen = rest[same]
        block = payloads if chosen.size == len(payloads) else payloads[chosen]
        paths = [p for p in dict.fromkeys(wanted(layout)) if p in layout.members]
        columns = _view(layout, block, paths)
        yield Group(chosen, layout, columns, names)
        rest = rest[~same]


def _equal(payloads: np.ndarray, rows: np.ndarray, first: bytes, at: int, size: int) -> np.ndarray:
    """Which payloads have the same bytes as the first one."""
    word = np.frombuffer(first, dtype=np.uint8)[at : at + size]
    return np.asarray((payloads[rows, at : at + size] == word).all(axis=1))


def _view(layout: Layout, block: np.ndarray, paths: list[str]) -> dict[str, np.ndarray]:
    kind = np.dtype(
        {
            "names": paths,
            "formats": [layout.members[path][0] for path in paths],
            "offsets": [layout.members[path][1] for path in paths],
            "itemsize": layout.size,
        }
    )
    if not paths:
        return {}
    table = np.ascontiguousarray(block).view(kind)[:, 0]
    return {path: table[path] for path in paths}
