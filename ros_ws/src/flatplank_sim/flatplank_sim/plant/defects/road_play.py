# SPDX-License-Identifier: Apache-2.0
"""The road plate can shift in its plank, because a bearing was cut off with the shortened end."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("road_play")
@dataclass(frozen=True)
class RoadPlay(Defect):
    """A gap along the travel; the tire pushes the plate across it when fx changes sign: dead
    travel * kappa = gap.
    """

    gap: float = size(0.00115, "m", "whole play of the road", (0.0, 0.01))
    friction: float = size(20.0, "N", "holds the road in its plank", (0.0, 2000.0))

    source = "thesis 3.1, hardware issue 8"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["road_gap"], m["road_friction"] = self.gap, self.friction
