# SPDX-License-Identifier: Apache-2.0
"""The calibration of the measuring hub is old."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("hub_gain")
@dataclass(frozen=True)
class HubGain(Defect):
    """Factors on the forces and moments at the wheel centre, in the bridges."""

    fx: float = size(0.02, "-", "relative error of Fx", (-0.5, 0.5))
    fy: float = size(0.0, "-", "of Fy", (-0.5, 0.5))
    fz: float = size(0.01, "-", "of Fz", (-0.5, 0.5))
    mx: float = size(0.0, "-", "of Mx", (-0.5, 0.5))
    mz: float = size(0.0, "-", "of Mz", (-0.5, 0.5))

    source = "thesis 3.1, hardware issue 19"
    touches = frozenset({"fx", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        for k, error in enumerate((self.fx, self.fy, self.fz, self.mx, self.mz)):
            site.mix[k, k] += error
