# SPDX-License-Identifier: Apache-2.0
"""Another backlash of the wheel drive than the +-15 deg that it has by nature."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("wheel_backlash")
@dataclass(frozen=True)
class WheelBacklash(Defect):
    """The dead zone of (5.16): after a torque reversal the motor turns and the wheel does not."""

    half_angle: float = size(0.5236, "rad", "half of the gap, at the motor", (0.0, 3.2))

    source = "thesis 5.5, figure 5.12"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.machine["backlash"] = self.half_angle
