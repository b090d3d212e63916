# SPDX-License-Identifier: Apache-2.0
"""The bus process's end of the two sockets: commands in, images out, requests and events. Never
blocks."""

from __future__ import annotations

import select
import socket
from typing import Any

from flatplank_hw.bus.image import AxisCommand, BusInputs
from flatplank_hw.ethercat.master import messages


class ParentLink:
    """A closed socket means that the parent is gone."""

    def __init__(self, data_fd: int, control_fd: int) -> None:
        self._data = socket.socket(fileno=data_fd)
        self._control = socket.socket(fileno=control_fd)
        self._data.setblocking(False)
        self._control.setblocking(False)
        self.parent_gone = False
        self.unread = 0
        """images that the parent was too slow to take"""

    def commands(self) -> list[AxisCommand]:
        """What came since the last look, oldest first."""
        return [messages.unpack_command(data) for data in self._drain(self._data)]

    def await_commands(self, seconds: float) -> list[AxisCommand]:
        """Likewise, but waits for one, at most so long [s]."""
        if seconds > 0.0 and not self.parent_gone:
            select.select([self._data], [], [], seconds)
        return self.commands()

    def requests(self) -> list[dict[str, Any]]:
        """Requests since the last look."""
        return [messages.unpack_json(data) for data in self._drain(self._control)]

    def publish(self, inputs: BusInputs) -> None:
        """One image; dropped and counted when the parent does not read."""
        try:
            self._data.send(messages.pack_inputs(inputs))
        except BlockingIOError:
            self.unread += 1
        except OSError:
            self.parent_gone = True

    def tell(self, message: dict[str, Any]) -> None:
        """An answer or an event."""
        try:
            self._control.send(messages.pack_json(message))
        except BlockingIOError:
            self.unread += 1
        except OSError:
            self.parent_gone = True

    def _drain(self, source: socket.socket) -> list[bytes]:
        found = []
        while not self.parent_gone:
            try:
                data = source.recv(messages.MAX_MESSAGE)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            if not data:
                self.parent_gone = True
                break
            found.append(data)
        return found
