# SPDX-License-Identifier: Apache-2.0
"""The road does not run at the speed that the slip control takes for granted."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("road_speed_error")
@dataclass(frozen=True)
class RoadSpeedError(Defect):
    """`relative` is a drive that is too fast and is seen by the pinion encoder; `unseen` is a
    wrong pitch radius.
    """

    relative: float = size(0.0013, "-", "speed over nominal speed, less one", (-0.2, 0.2))
    unseen: float = size(0.0, "-", "travel over what the encoder says, less one", (-0.2, 0.2))

    source = "thesis 6.3: 0.03096 m/s against 0.03092 m/s"
    touches = frozenset({"fx", "plank_counts"})
    spares = frozenset({"steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["speed_error"], m["scale_error"] = self.relative, self.unseen
