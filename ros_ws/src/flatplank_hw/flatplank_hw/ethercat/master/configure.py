# SPDX-License-Identifier: Apache-2.0
"""Writing a slave's configuration in PREOP: its SDOs, then mapping and assignment of its PDOs."""

from __future__ import annotations

from typing import Protocol

from flatplank_hw.ethercat.busfile import Pdo, Slave
from flatplank_hw.ethercat.layout import TYPES


class SdoTarget(Protocol):
    """The part of a slave that is needed here."""

    def sdo_write(self, index: int, subindex: int, data: bytes, ca: bool = False) -> None:
        """One download."""


def write_configuration(target: SdoTarget, slave: Slave) -> None:
    """Everything that the bus file wants written at start."""
    for sdo in slave.sdos:
        target.sdo_write(sdo.index, sdo.subindex, encode_value(sdo.kind, sdo.value))
    if slave.write_mapping:
        for pdo in (*slave.outputs, *slave.inputs):
            _write_list(target, pdo.index, [e.mapping_word for e in pdo.entries], 4)
    if slave.write_assignment:
        for index, pdos in ((0x1C12, slave.outputs), (0x1C13, slave.inputs)):
            if pdos:
                _write_list(target, index, _assigned(pdos), 2)


def encode_value(kind: str, value: int | str) -> bytes:
    """A value of the bus file as CoE bytes."""
    if kind == "string":
        return str(value).encode("utf-8")
    bits = TYPES[kind][0]
    return (int(value) & ((1 << bits) - 1)).to_bytes((bits + 7) // 8, "little")


def _assigned(pdos: tuple[Pdo, ...]) -> list[int]:
    return [pdo.index for pdo in pdos if pdo.assigned]


def _write_list(target: SdoTarget, index: int, items: list[int], size: int) -> None:
    """Empty, fill, then make valid by its count."""
    target.sdo_write(index, 0, b"\0")
    for position, item in enumerate(items, 1):
        target.sdo_write(index, position, item.to_bytes(size, "little"))
    target.sdo_write(index, 0, bytes([len(items)]))
