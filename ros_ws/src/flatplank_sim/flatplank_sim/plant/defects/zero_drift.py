# SPDX-License-Identifier: Apache-2.0
"""The zero of the bridges creeps away with time."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("zero_drift")
@dataclass(frozen=True)
class ZeroDrift(Defect):
    """Offset and drift of each amplifier channel."""

    offset: tuple[float, ...] = size((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), "V", "of C1..C6", (-5.0, 5.0))
    rate: tuple[float, ...] = size(
        (1e-5, 2e-5, 2e-5, 0.0, 1e-5, 1e-5), "V/s", "of C1..C6", (-1.0, 1.0)
    )

    source = "thesis appendix C (offsets between runs)"
    touches = frozenset({"fx", "fy", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fx_true"})

    def install(self, site: Site) -> None:
        site.drift[:6, 0] += self.offset
        site.drift[:6, 1] += self.rate
