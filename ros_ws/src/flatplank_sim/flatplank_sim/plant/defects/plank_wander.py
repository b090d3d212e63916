# SPDX-License-Identifier: Apache-2.0
"""The plank moves sideways along its travel, guided by bearings out of line."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("plank_wander")
@dataclass(frozen=True)
class PlankWander(Defect):
    """A lateral sine over the plank's position."""

    amplitude: float = size(0.0005, "m", "lateral", (0.0, 0.01))
    period: float = size(1.3, "m", "travel of one wave", (0.01, 20.0))
    phase: float = size(0.0, "rad", "at the start position")

    source = "thesis 3.1, hardware issue 11"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["wander"], m["wander_period"], m["wander_phase"] = (
            self.amplitude,
            self.period,
            self.phase,
        )
