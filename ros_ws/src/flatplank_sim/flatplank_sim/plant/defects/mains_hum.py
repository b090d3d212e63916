# SPDX-License-Identifier: Apache-2.0
"""The mains couple into the twelve metres of analogue cable. On by default."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("mains_hum")
@dataclass(frozen=True)
class MainsHum(Defect):
    """The same sine on all bridges; sampled at 250 Hz, 50 Hz stays 50 Hz."""

    amplitude: float = size(0.001, "V", "at C1..C6", (0.0, 1.0))
    frequency: float = size(50.0, "Hz", "of the mains", (0.0, 1000.0))

    source = "thesis 3.1, hardware issue 6"
    touches = frozenset({"fx", "fy", "fz"})
    spares = frozenset({"lvdt_volts", "plank_counts", "wheel_counts", "motor_position"})

    def install(self, site: Site) -> None:
        site.machine["hum"], site.machine["hum_frequency"] = self.amplitude, self.frequency
