# SPDX-License-Identifier: Apache-2.0
"""Interface of the panel to the bench; implemented by the ROS node, or by a stub in tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from flatplank_panel.bench_state import BenchState


class Reply(NamedTuple):
    """Answer to a request."""

    accepted: bool
    reason: str = ""
    values: Mapping[str, Any] = {}


class BenchLink(Protocol):
    """Link to the bench; the names of requests are those of `nodes/panel.py`."""

    state: BenchState

    async def ask(self, request: str, **fields: Any) -> Reply:
        """Call a service of the bench."""

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Reply:
        """Set parameters of a node, all or none."""

    async def get_parameters(self, node: str, names: Sequence[str]) -> dict[str, Any]:
        """Values of parameters; empty when the node is not there."""

    async def measure(self, plan: str, folder: str, simulated: bool) -> Reply:
        """Let the runner make a measurement or a campaign; progress goes to the state."""

    async def cancel(self) -> Reply:
        """Stop the measurement that the runner makes."""

    def send_heartbeat(self, token: str) -> None:
        """Heartbeat of the client in charge."""

    def offers(self, request: str) -> bool:
        """True when this bench serves the request."""

    def nodes(self) -> list[str]:
        """Names of the running nodes."""
