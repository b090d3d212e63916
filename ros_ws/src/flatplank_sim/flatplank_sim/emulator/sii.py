# SPDX-License-Identifier: Apache-2.0
"""Slave information (EEPROM) built from a slave of the bus file (ETG.1000.6, ETG.2010)."""

from __future__ import annotations

import struct

from flatplank_hw.ethercat.busfile import Pdo, Slave
from flatplank_hw.ethercat.layout import OCTETS

STRINGS, GENERAL, FMMUS, SYNC_MANAGERS, TX_PDO, RX_PDO, END = 10, 30, 40, 41, 50, 51, 0xFFFF
COE = 0x0004
_TYPE_CODES = {
    "bool": 0x01, "int8": 0x02, "int16": 0x03, "int32": 0x04, "uint8": 0x05, "uint16": 0x06,
    "uint32": 0x07, "string": 0x09, "int24": 0x10, "int64": 0x15, "uint24": 0x16, "uint64": 0x1B,
    **{f"bit{n}": 0x2F + n for n in range(2, 9)}, OCTETS: 0x0A,
}  # fmt: skip


def type_code(kind: str) -> int:
    """CoE number of a data type; padding has 0."""
    return _TYPE_CODES.get(kind, 0)


def build_sii(slave: Slave) -> bytes:
    """The whole EEPROM image."""
    names = _Strings([slave.name])
    pdos = b""
    for category, group in ((TX_PDO, slave.inputs), (RX_PDO, slave.outputs)):
        data = b"".join(_pdo(category, pdo, slave, names) for pdo in group)
        pdos += _category(category, data) if data else b""
    body = names.category()
    body += _category(GENERAL, _general(slave))
    body += _category(FMMUS, bytes([1, 2, 3 if slave.mailbox else 0xFF, 0xFF]))
    body += _category(SYNC_MANAGERS, _sync_managers(slave))
    body += pdos + END.to_bytes(2, "little") * 2
    return _header(slave, 128 + len(body)) + body


def _header(slave: Slave, size: int) -> bytes:
    words = bytearray(128)
    words[0:4] = bytes([0x80, 0x0C, 0x00, 0x66])
    words[14] = _crc(words[:14])
    identity = (slave.vendor, slave.product, slave.revision, slave.serial)
    words[16:32] = struct.pack("<4I", *identity)
    box = slave.mailbox
    if box is not None:
        words[0x30:0x3A] = struct.pack(
            "<5H", box.out_start, box.out_size, box.in_start, box.in_size, COE
        )
    kilobits = (size * 8 + 1023) // 1024
    words[0x7C:0x7E] = (max(kilobits, 16) - 1).to_bytes(2, "little")
    words[0x7E:0x80] = (1).to_bytes(2, "little")
    return bytes(words)


def _general(slave: Slave) -> bytes:
    data = bytearray(32)
    data[3] = 1
    if slave.mailbox is not None:
        info, complete = slave.mailbox.sdo_info, slave.mailbox.complete_access
        data[5] = 0x01 | 0x02 * info | 0x04 | 0x08 | 0x20 * complete
    data[12:14] = (100).to_bytes(2, "little")
    return bytes(data)


def _sync_managers(slave: Slave) -> bytes:
    memory, box = slave.memory, slave.mailbox
    rows = []
    if box is not None:
        rows += [
            (box.out_start, box.out_size, 0x26, 1, 1),
            (box.in_start, box.in_size, 0x22, 1, 2),
        ]
    for start, control, bits, kind in (
        (memory.outputs_start, memory.outputs_control, slave.output_bits, 3),
        (memory.inputs_start, memory.inputs_control, slave.input_bits, 4),
    ):
        if bits or box is not None:
            rows.append((start, (bits + 7) // 8, control, int(bits > 0), kind))
    return b"".join(struct.pack("<2HBxBB", *row) for row in rows)


def _pdo(category: int, pdo: Pdo, slave: Slave, names: _Strings) -> bytes:
    number = output_manager(slave) if category == RX_PDO else input_manager(slave)
    manager = number if pdo.assigned else 0xFF
    data = struct.pack("<HBBxB2x", pdo.index, len(pdo.entries), manager, names.add(pdo.name))
    for e in pdo.entries:
        words = (e.index, e.subindex, names.add(e.name), type_code(e.kind), e.bits)
        data += struct.pack("<H4B2x", *words)
    return data


def output_manager(slave: Slave) -> int:
    """Number of the sync manager that carries the outputs."""
    return 2 if slave.mailbox is not None else 0


def input_manager(slave: Slave) -> int:
    """Number of the sync manager that carries the inputs."""
    if slave.mailbox is not None:
        return 3
    return 1 if slave.output_bits else 0


class _Strings:
    def __init__(self, names: list[str]) -> None:
        self.names = names

    def add(self, name: str) -> int:
        """Add a string; returns its number, counted from 1; 0 for an empty name."""
        if not name:
            return 0
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name) + 1

    def category(self) -> bytes:
        data = bytes([len(self.names)])
        for name in self.names:
            text = name.encode("utf-8")[:255]
            data += bytes([len(text)]) + text
        return _category(STRINGS, data)


def _category(kind: int, data: bytes) -> bytes:
    data += b"\0" * (len(data) % 2)
    return kind.to_bytes(2, "little") + (len(data) // 2).to_bytes(2, "little") + data


def _crc(data: bytes | bytearray) -> int:
    """CRC-8 of the first fourteen bytes, polynomial 0x07, start 0xFF."""
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
    return crc
