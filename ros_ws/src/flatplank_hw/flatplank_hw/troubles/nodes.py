# SPDX-License-Identifier: Apache-2.0
"""Nodes that are missing, and calls that are refused."""

from __future__ import annotations

from flatplank_hw.troubles.trouble import Level, Trouble, table

NODES = table(
    Trouble(
        "refused", Level.WARN, "a call was refused",
        "what was asked for is not possible now or its values are wrong; nothing has changed",
        "",
    ),
    Trouble(
        "unconnected", Level.WARN, "nobody is at the other end of a topic",
        "the node that speaks or listens there was not started, or has ended",
        "start it; `ros2 node list` says which nodes run",
    ),
    Trouble(
        "node_silent", Level.ERROR, "a node is not heard any more",
        "it has ended, was killed, or hangs",
        "look for its last words in the terminal, then start the bench again",
    ),
    Trouble(
        "node_ended", Level.ERROR, "a node that the bench needs has ended",
        "it was killed or has given up; every node of a bench is needed, so the others end too",
        "read why in the lines before, then start the bench again",
    ),
)  # fmt: skip
