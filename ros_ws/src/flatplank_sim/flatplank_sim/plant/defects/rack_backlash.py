# SPDX-License-Identifier: Apache-2.0
"""Backlash of rack and pinion: a driving tire pushes the plank ahead of its pinion."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("rack_backlash")
@dataclass(frozen=True)
class RackBacklash(Defect):
    """A gap between pinion and rack, held by the friction of the plank's bearings; travel * kappa
    = gap.
    """

    gap: float = size(0.00064, "m", "backlash at the rack", (0.0, 0.01))
    friction: float = size(60.0, "N", "of the plank in its bearings", (0.0, 2000.0))

    source = "thesis 6.3, figure 6.7; together with the wheel drive 0.75 mm"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["rack_gap"], m["rack_friction"] = self.gap, self.friction
