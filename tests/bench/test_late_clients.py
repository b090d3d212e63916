# SPDX-License-Identifier: Apache-2.0
"""A client whose reader is not known yet when its request is answered: the answer is not lost."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import pytest

from flatplank_hw.nodes import late_clients
from flatplank_hw.nodes.late_clients import LateClients, until_heard


class Middleware:
    """A node and a service of it, in a middleware that drops answers to unknown readers."""

    def __init__(self, readers: int, clients: int = 1) -> None:
        self.readers, self.clients = readers, clients
        self.heard: list[str] = []
        self.warned: list[str] = []
        self.timers: list = []
        self.service_name = "/late/answer"

    def send_response(self, response: str, _header: int) -> None:
        if self.readers < self.clients:
            warnings.warn("failed to send response (timeout)", RuntimeWarning, stacklevel=1)
        else:
            self.heard.append(response)

    def get_publishers_info_by_topic(self, topic: str, *, no_mangle: bool) -> list[int]:
        assert topic.startswith("rq/late/answer") and topic.endswith("Request") and no_mangle
        return [0] * self.clients

    def get_subscriptions_info_by_topic(self, topic: str, *, no_mangle: bool) -> list[int]:
        assert topic.startswith("rr/late/answer") and topic.endswith("Reply") and no_mangle
        return [0] * self.readers

    def create_timer(self, _period: float, callback) -> object:
        self.timers.append(callback)
        return callback

    def destroy_timer(self, timer: object) -> None:
        self.timers.remove(timer)

    def get_logger(self) -> SimpleNamespace:
        return SimpleNamespace(warning=self.warned.append)

    def tick(self) -> None:
        for timer in tuple(self.timers):
            timer()


def test_an_answer_is_sent_once_its_reader_is_known():
    node = Middleware(readers=0)
    service = LateClients(node).watch(node)
    service.send_response("yes", 1)
    service.send_response("and no", 2)
    node.tick()
    assert node.heard == [] and len(node.timers) == 1
    node.readers = 1
    node.tick()
    assert node.heard == ["yes", "and no"] and not node.timers and not node.warned


def test_an_answer_that_is_heard_at_once_is_sent_once():
    node = Middleware(readers=1)
    LateClients(node).watch(node).send_response("yes", 1)
    assert node.heard == ["yes"] and not node.timers


def test_a_client_that_has_gone_is_given_up(monkeypatch: pytest.MonkeyPatch):
    node = Middleware(readers=0)
    monkeypatch.setattr(late_clients, "LOST_S", -1.0)
    LateClients(node).watch(node).send_response("yes", 1)
    node.tick()
    assert not node.timers
    assert node.warned == ["an answer of /late/answer was not sent: its client does not listen"]


def test_a_goal_waits_until_its_client_can_hear():
    node = Middleware(readers=0)
    waiting = until_heard(node, "/late/answer").__await__()
    next(waiting)
    node.tick()
    node.readers = 1
    node.tick()
    with pytest.raises(StopIteration):
        next(waiting)
    assert not node.timers
