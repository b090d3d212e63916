# SPDX-License-Identifier: Apache-2.0
"""SDO requests of the client, at most one per cycle and in order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from flatplank_data.names import nearest_hint
from flatplank_hw.ethercat.busfile import BusFile
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
