# SPDX-License-Identifier: Apache-2.0
"""One force of the hub shows in the channel of another."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("crosstalk")
@dataclass(frozen=True)
class Crosstalk(Defect):
    """Proportional to the other force, whatever the slip."""

    fz_to_fx: float = size(0.01, "-", "Fx per Fz", (-0.5, 0.5))
    fx_to_fz: float = size(0.0, "-", "Fz per Fx", (-0.5, 0.5))
    fx_to_fy: float = size(0.01, "-", "Fy per Fx", (-0.5, 0.5))
    fy_to_fx: float = size(0.0, "-", "Fx per Fy", (-0.5, 0.5))
    fz_to_fy: float = size(0.0, "-", "Fy per Fz", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 19"
    touches = frozenset({"fx", "fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        mix = site.mix
        mix[0, 2] += self.fz_to_fx
        mix[2, 0] += self.fx_to_fz
        mix[1, 0] += self.fx_to_fy
        mix[0, 1] += self.fy_to_fx
        mix[1, 2] += self.fz_to_fy
