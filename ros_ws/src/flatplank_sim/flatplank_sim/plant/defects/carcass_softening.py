# SPDX-License-Identifier: Apache-2.0
"""The carcass gets softer the further it is deflected."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("carcass_softening")
@dataclass(frozen=True)
class CarcassSoftening(Defect):
    """Force = stiffness * u / (1 + softening |u|)."""

    per_metre: float = size(15.0, "1/m", "softening", (0.0, 200.0))

    source = "REFERENCE section 6"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["softening"] = self.per_metre
