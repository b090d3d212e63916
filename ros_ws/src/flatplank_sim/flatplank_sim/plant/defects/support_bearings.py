# SPDX-License-Identifier: Apache-2.0
"""The plank rises and falls where it rolls onto or off a vertical support bearing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register
from flatplank_sim.plant.yamlconfig import PlantConfigError


@register("support_bearings")
@dataclass(frozen=True)
class SupportBearings(Defect):
    """Humps of the road at fixed plank positions; with a fixed axle height they are load, and
    through it fx.
    """

    positions: tuple[float, ...] = size((2.1, 2.9, 3.2), "m", "of road travel since the trigger")
    heights: tuple[float, ...] = size(
        (1.2e-4, -1.5e-4, 2.0e-4), "m", "of each hump, one for all if single", (-0.01, 0.01)
    )
    length: float = size(0.10, "m", "of a hump", (0.01, 2.0))

    source = "thesis 6.3, figure 6.6"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def check(self, where: str) -> None:
        super().check(where)
        if len(self.heights) not in (1, len(self.positions)):
            raise PlantConfigError(
                f"{where}: {len(self.heights)} heights for {len(self.positions)} positions;"
                " give one height for all or one each"
            )

    def install(self, site: Site) -> None:
        x = site.positions()
        heights = self.heights * (len(self.positions) if len(self.heights) == 1 else 1)
        for centre, height in zip(self.positions, heights, strict=True):
            u = np.clip((x - centre) / (0.5 * self.length), -1.0, 1.0)
            site.road_map[:, 1] += 0.5 * height * (1.0 + np.cos(np.pi * u))
        site.use_map()
