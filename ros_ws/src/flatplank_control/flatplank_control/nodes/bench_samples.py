# SPDX-License-Identifier: Apache-2.0
"""The latest samples of the nodes of the bench, for plans, and the arrival of the next ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.task import Future

from flatplank_control.runner.steps import Snapshot
from flatplank_hw.joining import CycleJoin
from flatplank_hw.nodes import convert, exchanges
from flatplank_hw.nodes.qos import STREAM

SOURCES = {
    "encoders": (exchanges.ENCODERS, "encoders/state"),
    "hub": (exchanges.HUB, "measurement_hub/state"),
    "contact": (exchanges.WRENCH, "measurement_hub/wrench_contact"),
    "drive": (exchanges.DRIVE, "wheel_drive/status"),
}
OF_HUB = ("hub", "contact")
"""topics that form one hub sample: joined by cycle"""

Subscribe = Callable[[type, str, Callable[[bytes], None], QoSProfile], Callable[[], None]]
"""subscribes to the serialised messages of a topic; returns a function that ends it"""


class BenchSamples:
    """Latest message of every source, kept serialised and decoded on request."""

    def __init__(self, subscribe: Subscribe) -> None:
        self._raw: dict[str, bytes] = {}
        self._join = CycleJoin(OF_HUB, self._on_hub)
        self._arrival: Future | None = None
        self._listening = False
        self._ends = [
            subscribe(exchange.msg_type, topic, partial(self._on_message, name), STREAM)
            for name, (exchange, topic) in SOURCES.items()
        ]

    def close(self) -> None:
        for end in self._ends:
            end()

    def _on_message(self, name: str, raw: bytes) -> None:
        if name in OF_HUB:
            self._join.put(name, convert.raw_stamp_ns(raw), raw)
        else:
            self._raw[name] = raw
        if self._listening:
            self.wake()

    def _on_hub(self, at: int, latest: Mapping[str, bytes]) -> None:
        contact = latest["contact"]
        if contact is not None and convert.raw_stamp_ns(contact) == at:
            self._raw |= latest

    async def wait_for_sample(self, listening: bool = True) -> None:
        """Wait for a sample, if `listening`, or for a call of `wake`."""
        self._arrival, self._listening = Future(), listening
        await self._arrival

    def wake(self) -> None:
        if self._arrival is not None and not self._arrival.done():
            self._arrival.set_result(None)

    def snapshot(self) -> Snapshot | None:
        """The latest samples; None until each source has one."""
        if len(self._raw) < len(SOURCES):
            return None
        read: dict[str, Any] = {
            name: exchange.read(deserialize_message(self._raw[name], exchange.msg_type))
            for name, (exchange, _) in SOURCES.items()
        }
        hub = read["hub"]._replace(contact=read["contact"].wrench)
        return Snapshot(read["encoders"], hub, read["drive"])

    def raw_drive_message(self) -> bytes | None:
        """Latest message of the drive, serialised; its cycle is the last complete one."""
        return self._raw.get("drive")

    def sources_without(self, cycle: int) -> list[str]:
        """Sources without a sample of this cycle."""
        s = self.snapshot()
        if s is None:
            return sorted(set(SOURCES) - set(self._raw))
        return [name for name, sample in s._asdict().items() if sample.cycle < cycle]

    def plank_moves(self) -> bool:
        s = self.snapshot()
        return s is not None and s.encoders.plank_moving
