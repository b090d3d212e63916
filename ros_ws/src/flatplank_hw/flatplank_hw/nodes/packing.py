# SPDX-License-Identifier: Apache-2.0
"""Serialises samples straight to the bytes of their messages.

rclpy makes a message object, then a C message, then bytes, and asks every field for its type. A
message whose texts and sequence lengths stay the same has one fixed layout in CDR, so its numbers
are put into a copy of one serialised example.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct
from typing import Any

from rclpy.serialization import serialize_message

from flatplank_data.bags.cdr import Layout, MessageType, layout_of, parse_definition

_ROS_NAMES = {"double": "float64", "float": "float32", "boolean": "bool", "octet": "byte"}
"""names of types in message classes -> those in definitions"""
_CODES = {
    "u1": "B", "i1": "b", "u2": "H", "i2": "h", "u4": "I", "i4": "i", "u8": "Q", "i8": "q",
    "f4": "f", "f8": "d",
}  # fmt: skip
"""numpy type -> format of struct"""


def pack_like(example: Any) -> Callable[[Sequence[float]], bytes]:
    """Function that serialises messages with the texts and sequence lengths of `example` from all
    their numbers, in the order of the definition.

    `example`: message of our own types, or of those in `flatplank_data.bags.cdr.STANDARD`.
    """
    given = serialize_message(example)
    layout = layout_of(_message_type(type(example)), given)
    template = _without_padding(given, layout)
    runs, first = [], 0
    for start, form, count in _runs(layout):
        runs.append((Struct(form).pack_into, start, slice(first, first + count)))
        first += count

    def pack(numbers: Sequence[float]) -> bytes:
        data = bytearray(template)
        for put, start, part in runs:
            put(data, start, *numbers[part])
        return bytes(data)

    return pack


def _message_type(kind: type) -> MessageType:
    """The type of a message class, as from its definition."""
    lines = []
    for name, of in kind.get_fields_and_field_types().items():  # type: ignore[attr-defined]
        element = of.removeprefix("sequence<").removesuffix(">")
        array = "[]" if element != of else ""
        lines.append(f"{_ROS_NAMES.get(element, element)}{array} {name}")
    package = kind.__module__.split(".")[0]
    return parse_definition(f"{package}/{kind.__name__}", "\n".join(lines))


def _without_padding(given: bytes, layout: Layout) -> bytes:
    """The example up to its last member; padding is zero there."""
    parts = [(0, 4)]
    parts += [(at, int(code[2])) for code, at in layout.members.values()]
    parts += [(at, 4) for at, _ in layout.lengths]
    parts += [(at, size + 1) for at, size in layout.texts.values()]
    data = bytearray(max(at + size for at, size in parts))
    for at, size in parts:
        data[at : at + size] = given[at : at + size]
    return bytes(data)


def _runs(layout: Layout) -> list[tuple[int, str, int]]:
    """Numbers that follow each other without a text or length between: offset of the first, format
    of struct, and how many."""
    constants = sorted(at for at, _ in layout.lengths)
    runs: list[tuple[int, str, int]] = []
    end = 0
    for code, at in layout.members.values():
        form, new = _CODES[code[1:]], not runs or any(end <= c < at for c in constants)
        if new:
            runs.append((at, f"<{form}", 1))
        else:
            start, before, count = runs[-1]
            runs[-1] = (start, f"{before}{'x' * (at - end)}{form}", count + 1)
        end = at + int(code[2])
    return runs
