# SPDX-License-Identifier: Apache-2.0
"""SDO information service: the object dictionary described to whoever asks (ETG.1000.6)."""

from __future__ import annotations

from flatplank_sim.emulator.dictionary import (
    ABORT_NO_OBJECT,
    ABORT_NO_SUBINDEX,
    VARIABLE,
    Dictionary,
)
from flatplank_sim.emulator.sii import type_code

LIST, DESCRIPTION, ENTRY, FAILED = 1, 3, 5, 7
_READ, _WRITE = 0x0007, 0x003F


class SdoInfo:
    """Answers one request with one or several fragments."""

    def __init__(self, dictionary: Dictionary, mailbox_size: int) -> None:
        self.dictionary = dictionary
        self.room = mailbox_size - 8
        self._services = {LIST: self._list, DESCRIPTION: self._description, ENTRY: self._entry}

    def serve(self, request: bytes) -> list[bytes]:
        """request: opcode, reserved, fragments, data."""
        opcode, data = request[0] & 0x7F, request[4:]
        service = self._services.get(opcode)
        if service is None:
            return [_failed(ABORT_NO_OBJECT)]
        return service(data)

    def _list(self, data: bytes) -> list[bytes]:
        indices = sorted(self.dictionary.objects)
        kind = data[0:2]
        if kind == b"\0\0":
            body = b"\0\0" + b"".join(n.to_bytes(2, "little") for n in (len(indices), 0, 0, 0, 0))
        else:
            body = kind + b"".join(index.to_bytes(2, "little") for index in indices)
        size = (self.room - 4) // 2 * 2
        parts = [body[i : i + size] for i in range(0, len(body), size)]
        return [
            _head(LIST + 1, len(parts) - 1 - i, more=i + 1 < len(parts)) + part
            for i, part in enumerate(parts)
        ]

    def _description(self, data: bytes) -> list[bytes]:
        index = int.from_bytes(data[0:2], "little")
        found = self.dictionary.objects.get(index)
        if found is None:
            return [_failed(ABORT_NO_OBJECT)]
        kind = type_code(found.subs[0].kind) if found.code == VARIABLE else 0
        largest = 0 if found.code == VARIABLE else max(found.subs)
        body = data[0:2] + kind.to_bytes(2, "little") + bytes([largest, found.code])
        return [_head(DESCRIPTION + 1) + body + found.name.encode("utf-8")[:40]]

    def _entry(self, data: bytes) -> list[bytes]:
        index, subindex = int.from_bytes(data[0:2], "little"), data[2]
        found = self.dictionary.objects.get(index)
        if found is None:
            return [_failed(ABORT_NO_OBJECT)]
        item = found.subs.get(subindex)
        if item is None:
            return [_failed(ABORT_NO_SUBINDEX)]
        body = data[0:4] + type_code(item.kind).to_bytes(2, "little")
        body += item.bits.to_bytes(2, "little")
        body += (_WRITE if item.writable else _READ).to_bytes(2, "little")
        return [_head(ENTRY + 1) + body + (item.name or found.name).encode("utf-8")[:40]]


def _head(opcode: int, fragments: int = 0, more: bool = False) -> bytes:
    return bytes([opcode | (0x80 if more else 0), 0]) + fragments.to_bytes(2, "little")


def _failed(code: int) -> bytes:
    return _head(FAILED) + code.to_bytes(4, "little")
