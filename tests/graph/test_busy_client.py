# SPDX-License-Identifier: Apache-2.0
"""A client on topics that never fall silent still hears the answer to its call."""

from __future__ import annotations

import pytest
from domains import loopback, next_domain
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from flatplank_control.nodes.client import BenchClient

pytestmark = pytest.mark.graph
IN_FLIGHT = 20


def test_an_answer_is_heard_among_messages_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    for key, value in loopback(next_domain()).items():
        monkeypatch.setenv(key, value)
    heard = []

    def on_ask(_request, response):
        response.success = True
        return response

    with BenchClient() as client:
        publisher = client.node.create_publisher(Empty, "/chatter", IN_FLIGHT)

        def say_again(message: Empty) -> None:
            heard.append(None)
            publisher.publish(message)

        client.node.create_subscription(Empty, "/chatter", say_again, IN_FLIGHT)
        client.node.create_service(Trigger, "/answer", on_ask)
        while not publisher.get_subscription_count():
            client.spin(0.01)
        for _ in range(IN_FLIGHT):
            publisher.publish(Empty())
        assert client.call(Trigger, "/answer", timeout=10.0).success
        before = len(heard)
        assert client.call(Trigger, "/answer", timeout=10.0).success
    # one message for the request and one for the answer, and a few while both are on their way
    assert 0 < len(heard) - before < 1000
