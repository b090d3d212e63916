# SPDX-License-Identifier: Apache-2.0
"""SDO server (ETG.1000.6): expedited, normal and segmented transfers, complete access."""

from __future__ import annotations

from collections.abc import Callable

from flatplank_sim.emulator.dictionary import (
    ABORT_LENGTH,
    ABORT_NO_OBJECT,
    ABORT_NO_SUBINDEX,
    ABORT_TOGGLE,
    ABORT_UNKNOWN_COMMAND,
    VARIABLE,
    Dictionary,
    SdoAbort,
)
from flatplank_sim.emulator.sii import type_code

COMPLETE = 0x10
HEADER = 8
"""mailbox header and CoE header [byte]"""
INIT_SIZE = HEADER + 8
"""header plus command, index, subindex and size of an initiated transfer [byte]"""


class SdoServer:
    """SDO server: one response per request; keeps the state of a segmented transfer."""

    def __init__(self, dictionary: Dictionary, mailbox_size: int) -> None:
        self.dictionary = dictionary
        self.room = mailbox_size
        self.abort_all = 0
        """injected fault: abort code for every request; 0: none"""
        self._upload = b""
        self._download: bytearray | None = None
        self._target = (0, 0, False)
        self._expected = 0
        self._toggle = 0
        self._services: dict[int, Callable[[int, bytes], bytes]] = {
            1: self._download_start,
            0: self._download_segment,
        }
        self._services |= {2: self._upload_start, 3: self._upload_segment}

    def serve(self, request: bytes) -> bytes:
        """Serve a request (command, index, subindex, data); returns a response of the same form,
        or b"" after an abort of the master."""
        request = request.ljust(8, b"\0")
        command = request[0]
        if command >> 5 == 4:
            self._download, self._upload = None, b""
            return b""
        address = request[1:4] if command >> 5 in (1, 2) else self._address()
        try:
            if self.abort_all:
                raise SdoAbort(self.abort_all)
            service = self._services.get(command >> 5)
            if service is None:
                raise SdoAbort(ABORT_UNKNOWN_COMMAND)
            return service(command, request)
        except SdoAbort as abort:
            self._download, self._upload = None, b""
            return b"\x80" + address + abort.code.to_bytes(4, "little")

    def _address(self) -> bytes:
        index, subindex, _ = self._target
        return index.to_bytes(2, "little") + bytes([subindex])

    def _open(self, command: int, request: bytes) -> bytes:
        index, subindex = int.from_bytes(request[1:3], "little"), request[3]
        self._target = (index, subindex, bool(command & COMPLETE))
        self._toggle = 0
        return request[1:4]

    def _upload_start(self, command: int, request: bytes) -> bytes:
        address = self._open(command, request)
        index, subindex, complete = self._target
        read = self.dictionary.read_complete if complete else self.dictionary.read
        data = read(index, subindex)
        mode = command & COMPLETE
        if 0 < len(data) <= 4:
            return bytes([0x43 | mode | (4 - len(data)) << 2]) + address + data.ljust(4, b"\0")
        size = len(data).to_bytes(4, "little")
        first = self.room - INIT_SIZE
        self._upload = data[first:]
        return bytes([0x41 | mode]) + address + size + data[:first]

    def _upload_segment(self, command: int, _request: bytes) -> bytes:
        toggle = command & 0x10
        if toggle != self._toggle or not self._upload:
            raise SdoAbort(ABORT_TOGGLE)
        size = self.room - HEADER - 1
        part, self._upload = self._upload[:size], self._upload[size:]
        self._toggle ^= 0x10
        unused = max(7 - len(part), 0)
        last = 0 if self._upload else 1
        return bytes([toggle | unused << 1 | last]) + part.ljust(7, b"\0")

    def _download_start(self, command: int, request: bytes) -> bytes:
        address = self._open(command, request)
        answer = bytes([0x60]) + address + bytes(4)
        if command & 0x02:
            self._store(request[4 : 8 - (command >> 2 & 3 if command & 1 else 0)])
            return answer
        self._expected = int.from_bytes(request[4:8], "little")
        data = request[8 : 8 + self._expected]
        if len(data) < self._expected:
            self._download = bytearray(data)
        else:
            self._store(bytes(data))
        return answer

    def _download_segment(self, command: int, request: bytes) -> bytes:
        toggle = command & 0x10
        if self._download is None or toggle != self._toggle:
            raise SdoAbort(ABORT_TOGGLE)
        self._toggle ^= 0x10
        data = request[1:]
        if len(data) == 7:
            data = data[: 7 - (command >> 1 & 7)]
        self._download += data
        if command & 1:
            whole = bytes(self._download)
            self._download = None
            if len(whole) != self._expected:
                raise SdoAbort(ABORT_LENGTH)
            self._store(whole)
        return bytes([0x20 | toggle]) + bytes(7)

    def _store(self, data: bytes) -> None:
        index, subindex, complete = self._target
        write = self.dictionary.write_complete if complete else self.dictionary.write
        write(index, subindex, data)


LIST, DESCRIPTION, ENTRY, FAILED = 1, 3, 5, 7
_READ, _WRITE = 0x0007, 0x003F


class SdoInfo:
    """SDO information server: one or several fragments per request."""

    def __init__(self, dictionary: Dictionary, mailbox_size: int) -> None:
        self.dictionary = dictionary
        self.room = mailbox_size - 8
        self._services = {LIST: self._list, DESCRIPTION: self._description, ENTRY: self._entry}

    def serve(self, request: bytes) -> list[bytes]:
        """Serve a request: opcode, reserved, fragments, data."""
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
