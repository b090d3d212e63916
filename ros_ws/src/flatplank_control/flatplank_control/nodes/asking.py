# SPDX-License-Identifier: Apache-2.0
"""Calls to other nodes without a time limit, and requests for their parameters."""

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
    """DDS writers (GIDs) that could answer when the call was made"""
    answer: Future


class PendingCalls:
    """Waits for answers as long as the called nodes exist; call `fail_ended_calls` regularly.

    A node that ends leaves the graph at once; a killed one when its lease expires (20 s with Fast
    DDS). A new node with the same name has not received the call, so servers are identified by
    their writer, not by name.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._open: list[_Question] = []

    async def call(self, client: Client, request: Any) -> Any:
        """Call a service and wait for the answer without limit; PlanFailed when its node has
        ended."""
        servers = self._servers(client)
        question = _Question(client, servers, client.call_async(request))
        self._open.append(question)
        try:
            return await question.answer
        finally:
            self._open.remove(question)
            client.remove_pending_request(question.answer)

    def fail_ended_calls(self) -> None:
        """Fail the calls whose node has ended."""
        for question in self._open:
            here = self._servers(question.client)
            gone = not question.client.service_is_ready() or not question.servers <= here
            if gone and not question.answer.done():
                name = question.client.service_name
                question.answer.set_exception(
                    PlanFailed(f"{name}: its node has ended before it answered; start it again")
                )

    def _servers(self, client: Client) -> frozenset[bytes]:
        """Writers of the answer topic, by its DDS name; empty with other middleware."""
        topic = f"rr{client.service_name}Reply"
        found = self._node.get_publishers_info_by_topic(topic, no_mangle=True)
        return frozenset(bytes(info.endpoint_gid) for info in found)


class NodeParameters:
    """Requests for the parameters of all running nodes; `wake` is called at each answer."""

    def __init__(self, clients: dict[str, Client], wake: Callable[[], None]) -> None:
        self._clients = {n: c for n, c in clients.items() if c.service_is_ready()}
        self._answers: dict[str, Future] = {}
        for name, client in self._clients.items():
            answer = client.call_async(GetParameters.Request(names=ASKED[name]))
            answer.add_done_callback(lambda _answer: wake())
            self._answers[name] = answer

    def unanswered(self) -> list[str]:
        """Nodes that have not answered yet."""
        return [name for name, answer in self._answers.items() if not answer.done()]

    def received(self) -> dict[str, dict[str, Any]]:
        """node -> parameter -> value; cancels unanswered requests."""
        for name in self.unanswered():
            self._clients[name].remove_pending_request(self._answers.pop(name))
        found = {}
        for name, answer in self._answers.items():
            # a node that lacks one of the parameters returns none, for instance a real bus
            if values := [parameter_value_to_python(v) for v in answer.result().values]:
                found[name] = dict(zip(ASKED[name], values, strict=True))
        return found


def parameter_clients(node: Node) -> dict[str, Client]:
    """Parameter clients of all nodes whose parameters go into a run record."""
    return {name: node.create_client(GetParameters, f"{name}/get_parameters") for name in ASKED}
