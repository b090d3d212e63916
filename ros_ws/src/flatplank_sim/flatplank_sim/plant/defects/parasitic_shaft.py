# SPDX-License-Identifier: Apache-2.0
"""The flexplate drum preloads the measuring shaft: forces in the bridges that no tire makes."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("parasitic_shaft")
@dataclass(frozen=True)
class ParasiticShaft(Defect):
    """Once per turn of the wheel, whatever slip and load."""

    fx: float = size(250.0, "N", "amplitude in Fx at the wheel centre", (0.0, 5000.0))
    fz: float = size(250.0, "N", "amplitude in Fz at the wheel centre", (0.0, 5000.0))
    phase: float = size(0.4, "rad", "at wheel angle zero")

    source = "thesis appendix C, figure C.1"
    touches = frozenset({"fx", "fz"})
    spares = frozenset(
        {"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy", "fx_true"}
    )

    def install(self, site: Site) -> None:
        m = site.machine
        m["para_fx"], m["para_fz"], m["para_phase"] = self.fx, self.fz, self.phase
