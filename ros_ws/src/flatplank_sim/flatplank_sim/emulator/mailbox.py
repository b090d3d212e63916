# SPDX-License-Identifier: Apache-2.0
"""Mailbox of a slave: CoE requests in, responses and emergencies out, one at a time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from flatplank_sim.emulator.dictionary import Dictionary
from flatplank_sim.emulator.sdo import SdoInfo, SdoServer

ERROR, COE = 0, 3
EMERGENCY, SDO_REQUEST, SDO_RESPONSE, SDO_INFO = 1, 2, 3, 8
ABORT = 0x80
"""command byte of an abort; both sides send it as a request"""
UNSUPPORTED_PROTOCOL, INVALID_HEADER = 2, 5


class Mailbox:
    """CoE mailbox of a slave: answers requests, and queues the messages for the master.

    Injected faults: `hang` ignores requests, `late_ns` delays the answers [ns of bench time].
    """

    def __init__(self, dictionary: Dictionary, size: int, offer: Callable[[bytes], bool]) -> None:
        self.sdo = SdoServer(dictionary, size)
        self.info = SdoInfo(dictionary, size)
        self.hang = False
        self.late_ns = 0
        self.now = 0
        self._offer = offer
        self._queue: deque[tuple[int, bytes]] = deque()
        self._counter = 0

    def reset(self) -> None:
        """Discard pending messages, as when the slave goes to INIT."""
        self._queue.clear()
        self._counter = 0

    def request(self, message: bytes) -> None:
        """Handle a message from the master."""
        if self.hang:
            return
        length, kind = int.from_bytes(message[0:2], "little"), message[5] & 0x0F
        body = message[6 : 6 + length]
        if kind != COE or len(body) < 3:
            code = UNSUPPORTED_PROTOCOL if kind != COE else INVALID_HEADER
            self._post(ERROR, (1).to_bytes(2, "little") + code.to_bytes(2, "little"))
            return
        service = int.from_bytes(body[0:2], "little") >> 12
        if service == SDO_REQUEST:
            answer = self.sdo.serve(body[2:])
            if answer:
                self._post(COE, _coe(SDO_REQUEST if answer[0] == ABORT else SDO_RESPONSE) + answer)
        elif service == SDO_INFO:
            for part in self.info.serve(body[2:]):
                self._post(COE, _coe(SDO_INFO) + part)

    def emergency(self, code: int, register: int, data: bytes = b"") -> None:
        """Queue an emergency message."""
        body = code.to_bytes(2, "little") + bytes([register]) + data[:5].ljust(5, b"\0")
        self._post(COE, _coe(EMERGENCY) + body)

    def offer_next(self, now: int) -> None:
        """Offer the next message when the master has fetched the last one."""
        self.now = now
        while self._queue and self._queue[0][0] <= now and self._offer(self._queue[0][1]):
            self._queue.popleft()

    def _post(self, kind: int, body: bytes) -> None:
        self._counter = self._counter % 7 + 1
        head = len(body).to_bytes(2, "little") + bytes([0, 0, 0, kind | self._counter << 4])
        self._queue.append((self.now + self.late_ns, head + body))
        self.offer_next(self.now)


def _coe(service: int) -> bytes:
    return (service << 12).to_bytes(2, "little")
