# SPDX-License-Identifier: Apache-2.0
"""Requests of the client that need the bus: at most one SDO per cycle, in order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from flatplank_data.params import nearest
from flatplank_hw.ethercat.busfile import BusFile

QUEUE = 64


class SdoTransport(Protocol):
    """Does one transfer; LookupError carries the reason of a failure."""

    def sdo_read(self, number: int, index: int, subindex: int) -> bytes:
        """Upload."""

    def sdo_write(self, number: int, index: int, subindex: int, data: bytes) -> None:
        """Download."""


class SdoQueue:
    """Keeps SDO requests until the cycle has time for one."""

    def __init__(self, bus: BusFile, answer: Callable[[dict[str, Any]], None]) -> None:
        self._names = [s.name for s in bus.slaves]
        self._answer = answer
        self._waiting: deque[dict[str, Any]] = deque()

    def put(self, request: dict[str, Any]) -> None:
        """Queue {id, do: sdo_read|sdo_write, slave, index, subindex[, data (hex)]}."""
        if request.get("slave") not in self._names:
            hint = nearest(request.get("slave", ""), self._names)
            self._refuse(request, f"no slave '{request.get('slave')}'{hint}")
        elif len(self._waiting) >= QUEUE:
            self._refuse(request, f"more than {QUEUE} SDO requests are waiting")
        else:
            self._waiting.append(request)

    def serve(self, transport: SdoTransport) -> bool:
        """Do one; whether there was one."""
        if not self._waiting:
            return False
        request = self._waiting.popleft()
        number = self._names.index(request["slave"])
        place = (number, int(request["index"]), int(request["subindex"]))
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
