# SPDX-License-Identifier: Apache-2.0
"""The axle height is fixed, not the load: braking lowers it, driving raises it a little."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("load_change")
@dataclass(frozen=True)
class LoadChange(Defect):
    """fz grows with fx, with different factors for driving and braking."""

    brake: float = size(0.0097, "1/kN", "relative load per braking force", (-0.2, 0.2))
    drive: float = size(0.0040, "1/kN", "relative load per driving force", (-0.2, 0.2))

    source = "thesis table 6.3: -3.6 % at -10 %, +1.5 % at +10 %"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["load_brake"], m["load_drive"] = self.brake / 1000.0, self.drive / 1000.0
