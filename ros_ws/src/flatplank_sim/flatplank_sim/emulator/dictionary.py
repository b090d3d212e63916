# SPDX-License-Identifier: Apache-2.0
"""The CoE object dictionary of a slave: objects with subindices, values as bytes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from flatplank_hw.ethercat.layout import TYPES, encode_value

VARIABLE, RECORD = 7, 9

ABORT_UNKNOWN_COMMAND = 0x05040001
ABORT_TOGGLE = 0x05030000
ABORT_READ_ONLY = 0x06010002
ABORT_NO_COMPLETE_ACCESS = 0x06010004
ABORT_NO_OBJECT = 0x06020000
ABORT_CANNOT_MAP = 0x06040041
ABORT_PDO_LENGTH = 0x06040042
ABORT_LENGTH = 0x06070010
ABORT_NO_SUBINDEX = 0x06090011
ABORT_STATE = 0x08000022


class SdoAbort(Exception):
    """An SDO transfer that the slave refuses, with the abort code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"SDO abort 0x{code:08X}")
        self.code = code


@dataclass
class Variable:
    """One subindex of an object."""

    kind: str
    value: bytes
    writable: bool = False
    name: str = ""
    read: Callable[[], bytes] | None = None
    """source of a value that is not stored"""
    wrote: Callable[[bytes], None] | None = None
    """called before a value is stored; may raise SdoAbort"""

    @property
    def bits(self) -> int:
        """Length [bit]."""
        return TYPES[self.kind][0] if self.kind in TYPES else len(self.get()) * 8

    def get(self) -> bytes:
        """Present value."""
        return self.value if self.read is None else self.read()


@dataclass
class Object:
    """One object of the dictionary."""

    name: str
    code: int
    subs: dict[int, Variable] = field(default_factory=dict)


def variable(kind: str, value: int | str, name: str = "", writable: bool = False) -> Variable:
    """A plain stored variable."""
    return Variable(kind, encode_value(kind, value), writable, name)


class Dictionary:
    """All objects of a slave, with checks of access; independent of mailboxes."""

    def __init__(self) -> None:
        self.objects: dict[int, Object] = {}

    def add(self, index: int, subindex: int, item: Variable, name: str = "") -> None:
        """Add a variable; a subindex above 0 makes or extends a record with its count at 0."""
        found = self.objects.get(index)
        if found is None:
            code = RECORD if subindex else VARIABLE
            found = self.objects[index] = Object(name or item.name, code)
        found.subs[subindex] = item
        if subindex and (0 not in found.subs or found.subs[0].name == "count"):
            found.code = RECORD if found.code == VARIABLE else found.code
            found.subs[0] = variable("uint8", max(found.subs), "count")

    def read(self, index: int, subindex: int) -> bytes:
        """Read one value."""
        return self._find(index, subindex).get()

    def write(self, index: int, subindex: int, data: bytes) -> None:
        """Store one value after its checks."""
        item = self._find(index, subindex)
        if not item.writable:
            raise SdoAbort(ABORT_READ_ONLY)
        if item.kind in TYPES and len(data) != (item.bits + 7) // 8:
            raise SdoAbort(ABORT_LENGTH)
        if item.wrote is not None:
            item.wrote(data)
        item.value = data

    def read_complete(self, index: int, first: int) -> bytes:
        """Read all subindices; subindex 0 takes two bytes, bits are packed."""
        found = self._object(index)
        if found.code == VARIABLE:
            raise SdoAbort(ABORT_NO_COMPLETE_ACCESS)
        data = found.subs[0].get().ljust(2, b"\0") if first == 0 else b""
        count = found.subs[0].get()[0]
        word = shift = 0
        for subindex in range(1, count + 1):
            if subindex in found.subs:
                item = found.subs[subindex]
                word |= int.from_bytes(item.get(), "little") << shift
                shift += item.bits
        return data + word.to_bytes((shift + 7) // 8, "little")

    def write_complete(self, index: int, first: int, data: bytes) -> None:
        """Write all subindices; a PDO list is emptied first, as with single writes."""
        found = self._object(index)
        if found.code == VARIABLE:
            raise SdoAbort(ABORT_NO_COMPLETE_ACCESS)
        count = data[0] if first == 0 and data else None
        if first == 0:
            data = data[2:]
        if count is not None and found.subs[0].writable:
            self.write(index, 0, b"\0")
        for subindex in range(1, max(found.subs) + 1):
            item = found.subs.get(subindex)
            if item is None or not data:
                continue
            size = (item.bits + 7) // 8
            self.write(index, subindex, data[:size])
            data = data[size:]
        if count is not None and found.subs[0].writable:
            self.write(index, 0, bytes([count]))

    def _object(self, index: int) -> Object:
        if index not in self.objects:
            raise SdoAbort(ABORT_NO_OBJECT)
        return self.objects[index]

    def _find(self, index: int, subindex: int) -> Variable:
        found = self._object(index)
        if subindex not in found.subs:
            raise SdoAbort(ABORT_NO_SUBINDEX)
        return found.subs[subindex]
