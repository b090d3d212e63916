# SPDX-License-Identifier: Apache-2.0
"""Slip from the road's travel over a whole run, with or without a learnt map."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.speed_map.learn import RoadMap

FOLLOW = "follow"
WHOLE_RUN = 100.0
"""[m]"""
NODE = "slip_sequencer"


def with_road(setup: BenchSetup, road: str) -> BenchSetup:
    """`road`: empty for constant speed, `follow` for the encoder's travel, else the file of a
    map."""
    if not road:
        return setup
    values: dict[str, Any] = {"follow_until": WHOLE_RUN}
    if road != FOLLOW:
        values |= RoadMap.load(Path(road)).parameters()
    own = {**setup.parameters.get(NODE, {}), **values}
    return replace(setup, parameters={**setup.parameters, NODE: own})
