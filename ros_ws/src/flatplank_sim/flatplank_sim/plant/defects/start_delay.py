# SPDX-License-Identifier: Apache-2.0
"""The wheel starts late: the road pulls at a standing tire first."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("start_delay")
@dataclass(frozen=True)
class StartDelay(Defect):
    """A resting wheel drive answers after a constant time."""

    time: float = size(0.15, "s", "from command to motion", (0.0, 5.0))

    source = "thesis 4.3, 5.6"
    touches = frozenset({"fx", "motor_position"})
    spares = frozenset({"plank_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.wheel_servo["start_delay"] = self.time
