# SPDX-License-Identifier: Apache-2.0
"""The protractor's zero is not the wheel's straight ahead."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("steering_zero_error")
@dataclass(frozen=True)
class SteeringZeroError(Defect):
    """alpha = steering angle + angle; neither encoder nor protractor shows it."""

    angle: float = size(-0.015, "rad", "true minus shown side slip angle", (-0.2, 0.2))

    source = "thesis table I.1: fy(0) = +869 N, fy = 0 at 1.0 deg"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        site.machine["steer_error"] = self.angle
