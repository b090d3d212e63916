# SPDX-License-Identifier: Apache-2.0
"""The two sockets between the bus process and its client, as the bus process uses them.

Data: packed tuples, one per message. Requests and events: JSON.
"""

from __future__ import annotations

import json
import select
import socket
import struct
from typing import Any

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs

_HEAD = "<qq7d5iBB"
_AXIS = "HbiiiH"
_INPUTS = struct.Struct(_HEAD + _AXIS * len(AXES))
_COMMAND = struct.Struct("<BqHbiiiB")
_WORDS = len(_AXIS)
MAX_MESSAGE = 65536


def pack_inputs(inputs: BusInputs) -> bytes:
    """Pack one cycle for the client."""
    flat: list[float] = [inputs.cycle, inputs.stamp_ns, *inputs.bridge_volts, *inputs[3:11]]
    for axis in inputs.axes:
        flat += axis
    return _INPUTS.pack(*flat)


def unpack_inputs(data: bytes) -> BusInputs:
    flat = _INPUTS.unpack(data)
    axes = tuple(
        AxisInputs._make(flat[i : i + _WORDS]) for i in range(16, 16 + _WORDS * len(AXES), _WORDS)
    )
    return BusInputs._make([flat[0], flat[1], flat[2:8], *flat[8:16], axes])


def pack_command(command: AxisCommand) -> bytes:
    """Pack one command for the bus process."""
    return _COMMAND.pack(*command)


def unpack_command(data: bytes) -> AxisCommand:
    return AxisCommand._make(_COMMAND.unpack(data))


class ParentLink:
    """End of the bus process: receives commands and requests, sends images and events; only
    `await_commands` waits. A closed socket means that the parent has ended."""

    def __init__(self, data_fd: int, control_fd: int) -> None:
        self._data = socket.socket(fileno=data_fd)
        self._control = socket.socket(fileno=control_fd)
        self._data.setblocking(False)
        self._control.setblocking(False)
        self.parent_gone = False
        self.unread = 0
        """images and messages dropped because the client did not read them in time"""

    def commands(self) -> list[AxisCommand]:
        """Commands received since the last call, oldest first."""
        return [unpack_command(data) for data in self._drain(self._data)]

    def await_commands(self, seconds: float) -> list[AxisCommand]:
        """Commands since the last call, as `commands`; waits for one, at most `seconds` [s]."""
        if seconds > 0.0 and not self.parent_gone:
            select.select([self._data], [], [], seconds)
        return self.commands()

    def requests(self) -> list[dict[str, Any]]:
        """Requests received since the last call."""
        return [json.loads(data) for data in self._drain(self._control)]

    def publish(self, inputs: BusInputs) -> None:
        """Send one image; it is dropped and counted when the parent does not read."""
        self._send(self._data, pack_inputs(inputs))

    def send_message(self, message: dict[str, Any]) -> None:
        """Send an answer or an event."""
        self._send(self._control, json.dumps(message).encode())

    def _send(self, target: socket.socket, data: bytes) -> None:
        try:
            target.send(data)
        except BlockingIOError:
            self.unread += 1
        except OSError:
            self.parent_gone = True

    def _drain(self, source: socket.socket) -> list[bytes]:
        found = []
        while not self.parent_gone:
            try:
                data = source.recv(MAX_MESSAGE)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            if not data:
                self.parent_gone = True
                break
            found.append(data)
        return found
