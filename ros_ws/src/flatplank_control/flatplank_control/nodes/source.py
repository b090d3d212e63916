# SPDX-License-Identifier: Apache-2.0
"""What the sources of set-points do alike: they work only while the drive is in their mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from std_msgs.msg import String

from flatplank_hw.joining import CycleJoin
from flatplank_hw.nodes import convert
from flatplank_hw.nodes.qos import LATCHED, REFERENCE, STREAM
from flatplank_hw.nodes.support import BenchNode
from flatplank_hw.samples import Reference
from flatplank_msgs.msg import EncoderState
from flatplank_msgs.msg import Reference as ReferenceMsg


class SourceNode(BenchNode):
    """Joins the samples of a cycle, asks its core, and publishes the reference with the core's
    state.

    A subclass has `core` (with `reset()`), `MODE`, the `KINDS` of samples that it needs beside the
    encoders, `compute(latest)` and `show()`, which publishes the inside of the core.
    """

    MODE: str
    KINDS: tuple[str, ...] = ("encoders",)

    def connect(self) -> None:
        self.message = ReferenceMsg()
        self.active = False
        self.publish = self.add_publisher(
            ReferenceMsg, "/wheel_drive/reference", REFERENCE, needed=True
        )
        self.add_subscription(EncoderState, "/encoders/state", self.on_encoders, STREAM)

    def listen_to_mode(self) -> None:
        """The last of `connect`: what a node hears first is called back first, so samples of the
        cycle before a new mode are over when the mode comes."""
        self.add_subscription(String, "/wheel_drive/mode", self.on_mode, LATCHED)

    def on_mode(self, msg: String) -> None:
        active = msg.data == self.MODE
        if active and not self.active:
            self.core.reset()
            self.join = CycleJoin(self.KINDS, self.on_cycle)
        self.active = active

    def on_encoders(self, msg: EncoderState) -> None:
        if self.active:
            sample = convert.encoders_from_msg(msg)
            self.join.put("encoders", sample.stamp_ns, sample)

    def on_cycle(self, _at: int, latest: Mapping[str, Any]) -> None:
        if any(sample is None for sample in latest.values()):
            return  # the first cycle came with less than all: nothing to say of it yet
        reference: Reference = self.compute(latest)
        convert.reference_to_msg(reference, self.message)
        self.publish(self.message)
        self.show(reference)
