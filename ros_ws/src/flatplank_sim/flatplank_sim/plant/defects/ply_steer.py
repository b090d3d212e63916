# SPDX-License-Identifier: Apache-2.0
"""The belt's plies make the tire pull sideways."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("ply_steer")
@dataclass(frozen=True)
class PlySteer(Defect):
    """A side slip angle of the tire's own, whichever side it is mounted on."""

    angle: float = size(0.003, "rad", "own side slip angle", (-0.1, 0.1))

    source = "REFERENCE section 6"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        site.tire["ply_steer"] = self.angle
