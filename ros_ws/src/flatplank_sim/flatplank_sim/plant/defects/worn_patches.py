# SPDX-License-Identifier: Apache-2.0
"""Patches of the sandpaper that have lost their grip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("worn_patches")
@dataclass(frozen=True)
class WornPatches(Defect):
    """Friction is lower at fixed road positions; felt by each bristle on its own place, grows with
    |slip|.
    """

    positions: tuple[float, ...] = size(
        (0.15, 2.35, 3.90), "m", "of road travel since the trigger"
    )
    factor: float = size(0.85, "-", "friction there over elsewhere", (0.05, 2.0))
    length: float = size(0.08, "m", "of a patch", (0.005, 2.0))

    source = "thesis 5.6"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        x = site.positions()
        for centre in self.positions:
            edge = np.clip((0.5 * self.length - np.abs(x - centre)) / 0.01 + 0.5, 0.0, 1.0)
            site.road_map[:, 0] *= 1.0 - (1.0 - self.factor) * edge
        site.use_map()
