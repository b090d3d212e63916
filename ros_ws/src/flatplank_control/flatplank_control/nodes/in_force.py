# SPDX-License-Identifier: Apache-2.0
"""Constants as the nodes of the graph have them now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python

from flatplank_control.calibration.book import CALIBRATED, Book

if TYPE_CHECKING:
    from flatplank_control.nodes.ros_bench import RosBench


async def constants_of(
    bench: RosBench, wanted: Mapping[str, Sequence[str]]
) -> dict[str, dict[str, Any]]:
    """node -> parameter -> value; PlanFailed when a node is not there."""
    found = {}
    for node, names in wanted.items():
        answer = await bench.call(GetParameters, f"/{node}/get_parameters", names=list(names))
        values = [parameter_value_to_python(value) for value in answer.values]
        found[node] = dict(zip(names, values, strict=True))
    return found


async def calibration_of(bench: RosBench, book: str) -> dict[str, Any]:
    """The `calibration` of a run record: the nodes' own constants, and what `book` knows."""
    in_force = await constants_of(bench, CALIBRATED)
    return Book(Path(book)).record(date.today(), in_force)
