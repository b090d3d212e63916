# SPDX-License-Identifier: Apache-2.0
"""Answers to clients that cannot hear yet.

The middleware meets the two ends of a client one after the other: the request may be here before
the reader of its answer is known. On a busy computer that takes longer than the 0.1 s for which
Fast DDS waits, and the answer would be lost.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node
from rclpy.task import Future

LOOK_S = 0.25
"""interval at which the readers are looked for [s]"""
LOST_S = 20.0
"""a reader that is not known after this time does not come: its process has gone [s]"""

Send = Callable[[Any, Any], None]


class _Answer(NamedTuple):
    service: str
    send: Send
    response: Any
    header: Any
    lost_at: float
    """[s of wall clock]"""


class LateClients:
    """Sends the answers of the services of a node again, when their clients can hear them."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._waiting: list[_Answer] = []
        self._timer: Any = None

    def watch(self, service: Any) -> Any:
        """The service; its answers are not lost from now on."""
        send = service.send_response

        def send_or_wait(response: Any, header: Any) -> None:
            if not _sent(send, response, header):
                lost_at = time.monotonic() + LOST_S
                self._waiting.append(
                    _Answer(service.service_name, send, response, header, lost_at)
                )
                self._timer = self._timer or self._node.create_timer(LOOK_S, self.send_again)

        service.send_response = send_or_wait
        return service

    def send_again(self) -> None:
        """Send the answers whose clients can hear; give up those that are lost."""
        waiting, self._waiting = self._waiting, []
        for answer in waiting:
            if can_hear(self._node, answer.service) and _sent(*answer[1:4]):
                continue
            if time.monotonic() < answer.lost_at:
                self._waiting.append(answer)
                continue
            self._node.get_logger().warning(
                f"an answer of {answer.service} was not sent: its client does not listen"
            )
        if not self._waiting:
            self._node.destroy_timer(self._timer)
            self._timer = None


def _sent(send: Send, response: Any, header: Any) -> bool:
    """Send an answer; rclpy warns when the middleware has dropped it."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", RuntimeWarning)
        send(response, header)
    return not said


def can_hear(node: Node, service: str) -> bool:
    """True when every client of a service that can ask can also hear the answer, by the names that
    ROS gives to the two topics of a service; true with other middleware."""
    writers = node.get_publishers_info_by_topic(f"rq{service}Request", no_mangle=True)
    readers = node.get_subscriptions_info_by_topic(f"rr{service}Reply", no_mangle=True)
    return len(readers) >= len(writers)


async def until_heard(node: Node, action: str) -> None:
    """Wait until the clients of an action can hear its answers, for `LOST_S` at most."""
    services = [f"{action}/_action/{name}" for name in ("send_goal", "get_result", "cancel_goal")]
    lost_at = time.monotonic() + LOST_S
    heard = Future()

    def look() -> None:
        over = all(can_hear(node, s) for s in services) or time.monotonic() > lost_at
        if over and not heard.done():
            heard.set_result(None)

    look()
    if not heard.done():
        timer = node.create_timer(LOOK_S, look)
        await heard
        node.destroy_timer(timer)
