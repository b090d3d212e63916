# SPDX-License-Identifier: Apache-2.0
"""The coefficients of the LVDT are no longer right."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("lvdt_error")
@dataclass(frozen=True)
class LvdtError(Defect):
    """Offset and gain of the axle height signal."""

    offset: float = size(0.02, "V", "at the LVDT", (-5.0, 5.0))
    gain: float = size(0.01, "-", "relative", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 18"
    touches = frozenset({"lvdt_volts"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fx", "fy", "fz"})

    def install(self, site: Site) -> None:
        site.drift[6] += (self.offset, self.gain)
