# SPDX-License-Identifier: Apache-2.0
"""The tire grips less when it brakes."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("drive_brake_asymmetry")
@dataclass(frozen=True)
class DriveBrakeAsymmetry(Defect):
    """Friction of the bristles that are pulled backwards."""

    friction: float = size(0.05, "-", "loss of friction when braking", (-0.5, 0.5))

    source = "thesis 6.3, figure 6.3"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["brake_friction"] = self.friction
