# SPDX-License-Identifier: Apache-2.0
"""Play between worm screw and worm gear of the steering: the tire steers itself."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("steering_play")
@dataclass(frozen=True)
class SteeringPlay(Defect):
    """The hub turns within the play when the moment about z passes the friction; the encoder sits
    on the screw.
    """

    angle: float = size(0.0035, "rad", "whole play", (0.0, 0.1))
    friction: float = size(3.0, "N m", "holds the hub", (0.0, 500.0))
    arm: float = size(0.03, "m", "of fx about the steering axis", (-0.3, 0.3))

    source = "thesis 3.1, hardware issue 10"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["steer_play"], m["steer_friction"], m["steer_arm"] = self.angle, self.friction, self.arm
