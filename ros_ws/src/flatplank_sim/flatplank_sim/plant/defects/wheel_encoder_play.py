# SPDX-License-Identifier: Apache-2.0
"""The wheel encoder's shaft is not firmly joined to the hub's shaft."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("wheel_encoder_play")
@dataclass(frozen=True)
class WheelEncoderPlay(Defect):
    """The encoder follows the wheel with a play."""

    angle: float = size(0.002, "rad", "whole play", (0.0, 0.2))

    source = "thesis 3.1, hardware issue 4"
    touches = frozenset({"wheel_counts"})
    spares = frozenset({"plank_counts", "motor_position", "fx", "fy", "fz", "lvdt_volts"})

    def install(self, site: Site) -> None:
        site.machine["wheel_encoder_play"] = self.angle
