# SPDX-License-Identifier: Apache-2.0
"""Tells of commands that the owner of the bus has refused, and who publishes commands."""

from __future__ import annotations

from collections import Counter

from flatplank_hw.bus.commanders import CommandGate
from flatplank_hw.bus.image import AXES
from flatplank_hw.nodes.support import BenchNode

COMMANDS = "bus/outputs"


def report_refused_commands(node: BenchNode, gate: CommandGate) -> None:
    """Report the axes with refused commands since the last call, and the publishers."""
    refused = gate.take_refused()
    if not refused:
        return
    axes = ", ".join(AXES[axis] if axis < len(AXES) else str(axis) for axis in sorted(refused))
    found = node.get_publishers_info_by_topic(node.resolve_topic_name(COMMANDS))
    names = Counter(f"{i.node_namespace.rstrip('/')}/{i.node_name}" for i in found)
    those = ", ".join(f"{n} of {name}" if n > 1 else name for name, n in sorted(names.items()))
    contested = any(gate.contested(axis) for axis in refused)
    then = "none of their commands is passed on" if contested else "its commands are refused"
    node.troubles.report_occurrence("second_commander", f"{axes}: {then}; publishers: {those}")
