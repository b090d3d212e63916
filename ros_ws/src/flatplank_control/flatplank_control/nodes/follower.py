# SPDX-License-Identifier: Apache-2.0
"""What the controllers of driven axes do alike: they have their axis while its drive is in mode
`follow`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import String

from flatplank_hw.joining import CycleJoin
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import LATCHED, REFERENCE, STREAM
from flatplank_hw.nodes.support import BenchNode
from flatplank_msgs.msg import EncoderState
from flatplank_msgs.msg import Reference as ReferenceMsg


class FollowerNode(BenchNode):
    """Contact wrench and encoders -> reference of one drive.

    A subclass has `core` with `reset()` and `reference(hub, encoders)`, and the name of its
    `drive`.
    """

    drive: str

    def connect(self) -> None:
        self.message = ReferenceMsg()
        self.active = False
        self.publish = self.add_publisher(
            ReferenceMsg, f"/{self.drive}/reference", REFERENCE, needed=True
        )
        self.add_subscription(String, f"/{self.drive}/mode", self.on_mode, LATCHED)
        self.add_subscription(EncoderState, "/encoders/state", self.on_encoders, STREAM)
        self.add_subscription(
            WrenchStamped, "/measurement_hub/wrench_contact", self.on_contact, STREAM
        )

    def on_mode(self, msg: String) -> None:
        active = msg.data == "follow"
        if active and not self.active:
            self.core.reset()
            self.join = CycleJoin(("encoders", "contact"), self.on_cycle)
        self.active = active

    def on_encoders(self, msg: EncoderState) -> None:
        if self.active:
            sample = convert.encoders_from_msg(msg)
            self.join.put("encoders", sample.stamp_ns, sample)

    def on_contact(self, msg: WrenchStamped) -> None:
        if self.active:
            self.join.put("contact", convert.stamp_ns(msg.header), convert.wrench_from_msg(msg))

    def on_cycle(self, _at: int, latest: Mapping[str, Any]) -> None:
        if any(sample is None for sample in latest.values()):
            return  # the first cycle came with less than all
        encoders = latest["encoders"]
        hub = convert.hub_of_contact(latest["contact"], encoders)
        convert.reference_to_msg(self.core.reference(hub, encoders), self.message)
        self.publish(self.message)
