# SPDX-License-Identifier: Apache-2.0
"""Packs numbers into the process data of one slave and unpacks them, LSB first."""

from __future__ import annotations

import struct
from collections.abc import Sequence

TYPES: dict[str, tuple[int, str, bool]] = {
    "bool": (1, "", False),
    **{f"bit{bits}": (bits, "", False) for bits in range(2, 8)},
    "bit8": (8, "B", False),
    "uint8": (8, "B", False),
    "int8": (8, "b", True),
    "uint16": (16, "H", False),
    "int16": (16, "h", True),
    "uint24": (24, "", False),
    "int24": (24, "", True),
    "uint32": (32, "I", False),
    "int32": (32, "i", True),
    "uint64": (64, "Q", False),
    "int64": (64, "q", True),
}
"""name of a CoE type -> (bits, struct code or empty when C has no such type, signed)"""


OCTETS = "octets"
"""type of a value of any length, written as hexadecimal digits"""


def range_of_type(kind: str) -> tuple[int, int]:
    """Smallest and largest value of a type."""
    bits, _, signed = TYPES[kind]
    return (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)


def encode_value(kind: str, value: int | str) -> bytes:
    """A value of the bus file as CoE bytes."""
    if kind == "string":
        return str(value).encode("utf-8")
    if kind == OCTETS:
        return bytes.fromhex(str(value))
    bits = TYPES[kind][0]
    return (int(value) & ((1 << bits) - 1)).to_bytes((bits + 7) // 8, "little")


class Layout:
    """Layout of typed entries; an entry of type '' is padding, also read as a number.

    Entries of whole bytes are packed by `struct`, others by bit shifts.
    """

    def __init__(self, entries: Sequence[tuple[str, int]]) -> None:
        """entries: (type name or '' for padding, bits)."""
        self.entries = tuple(entries)
        self.bits = sum(bits for _, bits in entries)
        self.size = (self.bits + 7) // 8
        self._struct: struct.Struct | None = None
        codes = [TYPES[kind][1] if kind else "B" * (bits == 8) for kind, bits in entries]
        if all(codes):
            self._struct = struct.Struct("<" + "".join(codes))

    def pack(self, values: Sequence[int]) -> bytes:
        """Pack numbers to bytes; the values must be in the range of their type."""
        if self._struct is not None:
            return self._struct.pack(*values)
        word = shift = 0
        for value, (_, bits) in zip(values, self.entries, strict=True):
            word |= (int(value) & ((1 << bits) - 1)) << shift
            shift += bits
        return word.to_bytes(self.size, "little")

    def unpack(self, data: bytes | bytearray) -> tuple[int, ...]:
        """Unpack bytes to numbers."""
        if self._struct is not None:
            return self._struct.unpack_from(data)
        word = int.from_bytes(data[: self.size], "little")
        values = []
        for kind, bits in self.entries:
            value = word & ((1 << bits) - 1)
            if kind and TYPES[kind][2] and value >> (bits - 1):
                value -= 1 << bits
            values.append(value)
            word >>= bits
        return tuple(values)
