# SPDX-License-Identifier: Apache-2.0
"""Questions to other nodes: calls without a time limit, and their parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from flatplank_control.runner.provenance import ASKED
from flatplank_control.runner.steps import PlanFailed


class _Question(NamedTuple):
    client: Client
    servers: frozenset[bytes]
    """identities of the writers that an answer may come from, known when it was asked"""
    answer: Future


class Asking:
    """Waits for answers as long as those who were asked are there; `look` now and then.

    A node that ends says so, one that is killed leaves the graph when its lease is over
    (20 s with Fast DDS). One of the same name that is started meanwhile has not received the
    question: servers are told apart by the identity of their writer, not by their name.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._open: list[_Question] = []

    async def ask(self, client: Client, request: Any) -> Any:
        """The answer, however long it takes; PlanFailed when nobody is left to give it."""
        servers = self._servers(client)
        question = _Question(client, servers, client.call_async(request))
        self._open.append(question)
        try:
            return await question.answer
        finally:
            self._open.remove(question)
            client.remove_pending_request(question.answer)

    def look(self) -> None:
        """Give up what nobody will answer."""
        for question in self._open:
            here = self._servers(question.client)
            gone = not question.client.service_is_ready() or not question.servers <= here
            if gone and not question.answer.done():
                name = question.client.service_name
                question.answer.set_exception(
                    PlanFailed(f"{name}: its node has ended before it answered; start it again")
                )

    def _servers(self, client: Client) -> frozenset[bytes]:
        """By the names that ROS gives to topics of DDS; empty where there is none of them."""
        topic = f"rr{client.service_name}Reply"
        found = self._node.get_publishers_info_by_topic(topic, no_mangle=True)
        return frozenset(bytes(info.endpoint_gid) for info in found)


class Asked:
    """Answers of all nodes that are there; `wake` is called whenever one has come."""

    def __init__(self, clients: dict[str, Client], wake: Callable[[], None]) -> None:
        self._clients = {n: c for n, c in clients.items() if c.service_is_ready()}
        self._answers: dict[str, Future] = {}
        for name, client in self._clients.items():
            answer = client.call_async(GetParameters.Request(names=ASKED[name]))
            answer.add_done_callback(lambda _answer: wake())
            self._answers[name] = answer

    def waiting(self) -> list[str]:
        """Nodes that have not answered."""
        return [name for name, answer in self._answers.items() if not answer.done()]

    def take(self) -> dict[str, dict[str, Any]]:
        """node -> parameter -> value; what was not answered is asked no more."""
        for name in self.waiting():
            self._clients[name].remove_pending_request(self._answers.pop(name))
        found = {}
        for name, answer in self._answers.items():
            # none where a node does not have one of them: a real bus simulates no machine
            if values := [parameter_value_to_python(v) for v in answer.result().values]:
                found[name] = dict(zip(ASKED[name], values, strict=True))
        return found


def clients(node: Node) -> dict[str, Client]:
    """Of every node that a run record is made of."""
    return {name: node.create_client(GetParameters, f"/{name}/get_parameters") for name in ASKED}
