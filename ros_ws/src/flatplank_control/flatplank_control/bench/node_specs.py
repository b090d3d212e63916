# SPDX-License-Identifier: Apache-2.0
"""The processes of a bench by name: one table for whoever starts, asks or describes them."""

from __future__ import annotations

from typing import NamedTuple


class NodeSpec(NamedTuple):
    """One process of the bench."""

    package: str
    executable: str
    name: str
    in_loop: bool = False
    """its answer is due within the cycle"""


BUSES = {
    "sim": NodeSpec("flatplank_sim", "simulated_plant", "simulated_plant", True),
    "emulated": NodeSpec("flatplank_sim", "emulated_bus", "ethercat_bus", True),
    "lab": NodeSpec("flatplank_hw", "ethercat_bus", "ethercat_bus", True),
}
"""kind of bench -> node that owns its bus"""

NODES = (
    NodeSpec("flatplank_hw", "measurement_hub", "measurement_hub", True),
    NodeSpec("flatplank_hw", "encoders", "encoders", True),
    NodeSpec("flatplank_hw", "wheel_drive", "wheel_drive", True),
    NodeSpec("flatplank_control", "free_rolling_controller", "free_rolling_controller", True),
    NodeSpec("flatplank_control", "slip_sequencer", "slip_sequencer", True),
    NodeSpec("flatplank_control", "recorder", "recorder"),
    NodeSpec("flatplank_control", "measurement_runner", "measurement_runner"),
)
"""What runs beside the bus, whatever the bus is."""


class AxisNodes(NamedTuple):
    """A driven axis that a controller leads."""

    drive: NodeSpec
    controller: NodeSpec


AXIS_NODES: dict[str, AxisNodes] = {
    "vertical": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "vertical_drive", True),
        NodeSpec("flatplank_control", "load_controller", "load_controller", True),
    ),
    "steer": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "steer_drive", True),
        NodeSpec("flatplank_control", "axis_hold", "steering_hold", True),
    ),
    "camber": AxisNodes(
        NodeSpec("flatplank_hw", "wheel_drive", "camber_drive", True),
        NodeSpec("flatplank_control", "axis_hold", "camber_hold", True),
    ),
}
"""axis that a controller leads -> its nodes"""

DRIVEN: dict[str, tuple[NodeSpec, ...]] = {
    "plank": (NodeSpec("flatplank_hw", "wheel_drive", "plank_drive", True),),
    **AXIS_NODES,
}
"""axis that may be driven beside the wheel -> its nodes, the drive first; the runner leads the
plank"""
