# SPDX-License-Identifier: Apache-2.0
"""Message definitions as text (`.msg`) to fields; a bag carries the text of its own types."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

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
    """Fields of a type and of all the types it is made of, by short name (`pkg/Name`)."""

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
