# SPDX-License-Identifier: Apache-2.0
"""The adapter is not concentric with the hub: the wheel runs out once per turn."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("run_out")
@dataclass(frozen=True)
class RunOut(Defect):
    """Deflection and rolling radius vary with the wheel angle, order 1."""

    amplitude: float = size(2e-4, "m", "radial", (0.0, 0.02))
    phase: float = size(0.0, "rad", "wheel angle of the largest radius")
    rolling_share: float = size(0.3, "-", "of it in the rolling radius", (0.0, 2.0))

    source = "thesis 3.1, hardware issue 15"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["runout"], m["runout_phase"] = self.amplitude, self.phase
        m["runout_rolling"] = self.amplitude * self.rolling_share
