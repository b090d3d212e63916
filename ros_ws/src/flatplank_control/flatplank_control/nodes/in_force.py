# SPDX-License-Identifier: Apache-2.0
"""Parameters as the nodes of the graph have them now."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from flatplank_control.runner.provenance import ASKED


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
