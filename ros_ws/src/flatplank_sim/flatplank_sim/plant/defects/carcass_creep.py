# SPDX-License-Identifier: Apache-2.0
"""The rubber creeps: part of the carcass deflection comes late."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("carcass_creep")
@dataclass(frozen=True)
class CarcassCreep(Defect):
    """A Kelvin element in series with the carcass."""

    share: float = size(0.15, "-", "delayed over elastic deflection", (0.0, 2.0))
    time: float = size(5.0, "s", "constant of the creep", (0.01, 1000.0))

    source = "REFERENCE section 6"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["creep"], site.tire["creep_time"] = self.share, self.time
