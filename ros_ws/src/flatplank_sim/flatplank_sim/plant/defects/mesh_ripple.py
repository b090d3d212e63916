# SPDX-License-Identifier: Apache-2.0
"""Speed ripple of the rack and pinion mesh, which the encoder on the pinion cannot see."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, size
from flatplank_sim.plant.defects.registry import register


@register("mesh_ripple")
@dataclass(frozen=True)
class MeshRipple(Defect):
    """Position error of the plank, periodic in a tooth and in a turn of the pinion."""

    tooth: float = size(20e-6, "m", "amplitude once per tooth", (0.0, 0.005))
    turn: float = size(30e-6, "m", "amplitude once per turn of the pinion", (0.0, 0.005))
    pitch: float = size(0.01571, "m", "travel of one tooth", (0.001, 0.2))
    phase: float = size(0.0, "rad", "at the start position")

    source = "thesis 3.1, hardware issue 5"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["mesh_tooth"], m["mesh_turn"] = self.tooth, self.turn
        m["mesh_pitch"], m["mesh_phase"] = self.pitch, self.phase
