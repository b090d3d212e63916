# SPDX-License-Identifier: Apache-2.0
"""Configures a slave in PREOP: its SDOs, then mapping and assignment of its PDOs."""

from __future__ import annotations

import pysoem

from flatplank_hw.ethercat.busfile import Slave
from flatplank_hw.ethercat.layout import encode_value


def write_configuration(target: pysoem.CdefSlave, slave: Slave) -> None:
    """Write the SDOs, mapping and assignment of a slave of the bus file, in PREOP."""
    for sdo in slave.sdos:
        target.sdo_write(sdo.index, sdo.subindex, encode_value(sdo.kind, sdo.value))
    if slave.write_mapping:
        for pdo in (*slave.outputs, *slave.inputs):
            _write_list(target, pdo.index, [e.mapping_word for e in pdo.entries], 4)
    if slave.write_assignment:
        for index, pdos in ((0x1C12, slave.outputs), (0x1C13, slave.inputs)):
            if pdos:
                _write_list(target, index, [p.index for p in pdos if p.assigned], 2)


def _write_list(target: pysoem.CdefSlave, index: int, items: list[int], size: int) -> None:
    """Write a list: set its count to 0, write the items, then set the count."""
    target.sdo_write(index, 0, b"\0")
    for position, item in enumerate(items, 1):
        target.sdo_write(index, position, item.to_bytes(size, "little"))
    target.sdo_write(index, 0, bytes([len(items)]))
