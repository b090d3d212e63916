# SPDX-License-Identifier: Apache-2.0
"""The plank drive yields to the tire: driving pushes it, braking holds it back."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("speed_droop")
@dataclass(frozen=True)
class SpeedDroop(Defect):
    """Speed rises with fx."""

    per_kn: float = size(0.0008, "1/kN", "relative speed per longitudinal force", (-0.1, 0.1))

    source = "thesis table 6.3, figure 6.5"
    touches = frozenset({"fx", "plank_counts"})
    spares = frozenset({"steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.machine["droop"] = self.per_kn / 1000.0
