# SPDX-License-Identifier: Apache-2.0
"""Play between half-moon guides and rotation supports of the road."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("rotation_support_play")
@dataclass(frozen=True)
class RotationSupportPlay(Defect):
    """Sideways a gap that the lateral force crosses; vertically the road sinks while the load
    rises through a window.
    """

    gap_y: float = size(0.003, "m", "lateral play", (0.0, 0.02))
    gap_z: float = size(0.0013, "m", "vertical play", (0.0, 0.02))
    load_from: float = size(1300.0, "N", "load where the road begins to sink", (0.0, 10000.0))
    load_to: float = size(2900.0, "N", "load where it rests again", (1.0, 20000.0))
    friction: float = size(40.0, "N", "holds the road sideways", (0.0, 2000.0))

    source = "thesis 3.1, hardware issue 9; figure G.5"
    touches = frozenset({"fy", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["support_gap_y"], m["support_gap_z"] = self.gap_y, self.gap_z
        m["support_from"] = self.load_from
        m["support_to"] = max(self.load_to, self.load_from + 1.0)
        m["support_friction"] = self.friction
