# SPDX-License-Identifier: Apache-2.0
"""What goes over the two sockets between the bus process and its client.

Data: packed tuples, one per message. Requests and events: JSON.
"""

from __future__ import annotations

import json
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
    """One cycle for the client."""
    flat: list[float] = [inputs.cycle, inputs.stamp_ns, *inputs.bridge_volts, *inputs[3:11]]
    for axis in inputs.axes:
        flat += axis
    return _INPUTS.pack(*flat)


def unpack_inputs(data: bytes) -> BusInputs:
    """The same on the other side."""
    flat = _INPUTS.unpack(data)
    axes = tuple(
        AxisInputs._make(flat[i : i + _WORDS]) for i in range(16, 16 + _WORDS * len(AXES), _WORDS)
    )
    return BusInputs._make([flat[0], flat[1], flat[2:8], *flat[8:16], axes])


def pack_command(command: AxisCommand) -> bytes:
    """One command for the bus process."""
    return _COMMAND.pack(*command)


def unpack_command(data: bytes) -> AxisCommand:
    """The same on the other side."""
    return AxisCommand._make(_COMMAND.unpack(data))


def pack_json(message: dict[str, Any]) -> bytes:
    """A request, an answer or an event."""
    return json.dumps(message).encode()


def unpack_json(data: bytes) -> dict[str, Any]:
    """The same on the other side."""
    return json.loads(data)
