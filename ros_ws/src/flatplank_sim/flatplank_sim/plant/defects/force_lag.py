# SPDX-License-Identifier: Apache-2.0
"""The measuring amplifier filters the bridges."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("force_lag")
@dataclass(frozen=True)
class ForceLag(Defect):
    """First-order low-pass in time on all bridges."""

    time: float = size(0.03, "s", "constant", (0.0, 5.0))

    source = "thesis 5.6: filtered by the measurement amplifier"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        site.machine["lag"] = self.time
