# SPDX-License-Identifier: Apache-2.0
"""Heartbeats: of the process that makes a measurement, and of the client that asked for it."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import String

from flatplank_msgs.srv import Claim

TOPIC, DEPTH = "operator/heartbeat", 10
BEAT = 0.1
"""interval of the heartbeats of the runner [s]"""
LOOK = 0.25
"""interval of the looks at the heartbeats of a client [s]"""
MISSING = 20
"""looks without a heartbeat after which the client has gone: 5 s"""


class Charge:
    """The claim of the process that makes a measurement: without its heartbeats the axes stop."""

    def __init__(self, node: Node) -> None:
        self.node, self.token = node, ""
        """`token`: sent with every heartbeat; empty: not in charge, none is sent"""
        self.claim = node.create_client(Claim, "operator/claim")
        self._beat = node.create_publisher(String, TOPIC, DEPTH)
        self._timer = node.create_timer(BEAT, self._send)

    def close(self) -> None:
        self.node.destroy_timer(self._timer)
        self.node.destroy_client(self.claim)
        self.node.destroy_publisher(self._beat)

    def _send(self) -> None:
        if self.token:
            self._beat.publish(String(data=self.token))


class Watched:
    """Whether the client of a goal lives."""

    def __init__(self) -> None:
        self.token, self._looks = "", 0

    def begin(self, token: str) -> None:
        """Watch the client whose heartbeats have this token; empty: watch none."""
        self.token, self._looks = token, 0

    def hear(self, message: String) -> None:
        """Register a heartbeat, from whomever."""
        if message.data == self.token:
            self._looks = 0

    def look(self) -> None:
        """Count a look. A process that was held up counts none, as it hears none."""
        self._looks += 1

    @property
    def gone(self) -> bool:
        return bool(self.token) and self._looks > MISSING
