# SPDX-License-Identifier: Apache-2.0
"""The carcass stiffness depends on pressure more than the tire's own table says."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("carcass_pressure")
@dataclass(frozen=True)
class CarcassPressure(Defect):
    """Exponent added to that of the longitudinal carcass stiffness over pressure."""

    exponent: float = size(0.5, "-", "added", (-2.0, 2.0))

    source = "thesis 7.4"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["cx_p"] += self.exponent
