# SPDX-License-Identifier: Apache-2.0
"""Forces and motion are recorded by two machines whose clocks differ."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("time_skew")
@dataclass(frozen=True)
class TimeSkew(Defect):
    """All bridges are late by a constant time against encoders and drive."""

    delay: float = size(0.05, "s", "of the bridges", (0.0, 0.9))

    source = "thesis 3.2: two unsynchronised data sets"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        site.machine["skew"] = self.delay
