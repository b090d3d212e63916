# SPDX-License-Identifier: Apache-2.0
"""The tire is a little conical."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("conicity")
@dataclass(frozen=True)
class Conicity(Defect):
    """A camber of the tire's own."""

    camber: float = size(0.01, "rad", "own camber", (-0.2, 0.2))

    source = "REFERENCE section 6"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        site.tire["conicity"] = self.camber
