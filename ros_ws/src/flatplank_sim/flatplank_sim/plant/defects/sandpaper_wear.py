# SPDX-License-Identifier: Apache-2.0
"""The sandpaper wears from run to run."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("sandpaper_wear")
@dataclass(frozen=True)
class SandpaperWear(Defect):
    """Friction falls in proportion to the number of runs since the plant was made."""

    per_run: float = size(0.0005, "1/run", "loss of friction", (0.0, 0.2))

    source = "thesis 3.1, hardware issue 13"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.machine["wear"] = self.per_run
