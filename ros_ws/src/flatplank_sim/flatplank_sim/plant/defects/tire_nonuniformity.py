# SPDX-License-Identifier: Apache-2.0
"""The tire's stiffness varies over its circumference."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("tire_nonuniformity")
@dataclass(frozen=True)
class TireNonuniformity(Defect):
    """Radial force variation of orders 1 to 3 of the wheel angle, with a rolling radius that
    follows it.
    """

    order1: float = size(25.0, "N", "amplitude once per turn", (0.0, 1000.0))
    order2: float = size(12.0, "N", "twice per turn", (0.0, 1000.0))
    order3: float = size(8.0, "N", "three times per turn", (0.0, 1000.0))
    phase: float = size(0.7, "rad", "wheel angle of the peaks")
    rolling: float = size(1e-6, "m/N", "rolling radius per radial force", (-1e-4, 1e-4))

    source = "REFERENCE section 6; thesis 5.6 (three start angles)"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["nu1"], m["nu2"], m["nu3"] = self.order1, self.order2, self.order3
        m["nu_phase"], m["nu_rolling"] = self.phase, self.rolling
