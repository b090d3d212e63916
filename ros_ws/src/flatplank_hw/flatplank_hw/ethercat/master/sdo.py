# SPDX-License-Identifier: Apache-2.0
"""SDO requests of the client, at most one per cycle and in order. Also configures a slave in
PREOP: its SDOs, then mapping and assignment of its PDOs."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from flatplank_data.names import nearest_hint
from flatplank_hw.ethercat.busfile import BusFile, Slave
from flatplank_hw.ethercat.layout import encode_value

if TYPE_CHECKING:
    import pysoem

    from flatplank_hw.ethercat.master.soem import SoemBus

QUEUE = 64
"""largest number of waiting requests"""


class SdoQueue:
    """Queue of SDO requests; the cycle serves one when it has time."""

    def __init__(self, bus: BusFile, answer: Callable[[dict[str, Any]], None]) -> None:
        self._names = [s.name for s in bus.slaves]
        self._answer = answer
        self._waiting: deque[dict[str, Any]] = deque()

    def put(self, request: dict[str, Any]) -> None:
        """Queue {id, do: sdo_read|sdo_write, slave, index, subindex[, data (hex)]}."""
        if request.get("slave") not in self._names:
            hint = nearest_hint(request.get("slave", ""), self._names)
            self._refuse(request, f"no slave '{request.get('slave')}'{hint}")
        elif len(self._waiting) >= QUEUE:
            self._refuse(request, f"more than {QUEUE} SDO requests are waiting")
        else:
            self._waiting.append(request)

    def serve(self, transport: SoemBus) -> bool:
        """Serve one request; false when there is none."""
        if not self._waiting:
            return False
        request = self._waiting.popleft()
        number = self._names.index(request["slave"])
        place = (number, request["index"], request["subindex"])
        try:
            if request["do"] == "sdo_read":
                data = transport.sdo_read(*place).hex()
            else:
                transport.sdo_write(*place, bytes.fromhex(request["data"]))
                data = ""
        except LookupError as error:
            self._refuse(request, str(error))
        else:
            self._answer({"id": request["id"], "ok": True, "data": data})
        return True

    def _refuse(self, request: dict[str, Any], reason: str) -> None:
        self._answer({"id": request["id"], "ok": False, "reason": reason})


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
