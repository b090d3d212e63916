# SPDX-License-Identifier: Apache-2.0
"""Plays of rack, steering and rotation supports, and the zero of the steering."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class RackBacklash(Defect):
    """Backlash of rack and pinion: a driving tire pushes the plank ahead of the pinion.

    A gap between pinion and rack, held by the friction of the plank's bearings; travel * kappa
    = gap.
    """

    gap: float = defect_param(0.00064, "m", "backlash at the rack", (0.0, 0.01), "rack_gap")
    friction: float = defect_param(
        60.0, "N", "of the plank in its bearings", (0.0, 2000.0), "rack_friction"
    )

    source = "thesis 6.3, figure 6.7; together with the wheel drive 0.75 mm"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class SteeringPlay(Defect):
    """Play between worm screw and worm gear of the steering: the tire steers itself.

    The hub turns within the play when the moment about z exceeds the friction; the encoder sits on
    the screw.
    """

    angle: float = defect_param(0.0035, "rad", "whole play", (0.0, 0.1), "steer_play")
    friction: float = defect_param(3.0, "N m", "holds the hub", (0.0, 500.0), "steer_friction")
    arm: float = defect_param(0.03, "m", "of fx about the steering axis", (-0.3, 0.3), "steer_arm")

    source = "thesis 3.1, hardware issue 10"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})


@dataclass(frozen=True)
class SteeringZeroError(Defect):
    """The zero of the protractor is not the straight-ahead position of the wheel.

    alpha = steering angle + angle; neither encoder nor protractor shows it.
    """

    angle: float = defect_param(
        -0.015, "rad", "true minus shown side slip angle", (-0.2, 0.2), "steer_error"
    )

    source = "thesis table I.1: fy(0) = +869 N, fy = 0 at 1.0 deg"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})


@dataclass(frozen=True)
class RotationSupportPlay(Defect):
    """Play between half-moon guides and rotation supports of the road.

    The lateral force moves the road across the lateral play; vertically the road sinks while the
    load rises from `load_from` to `load_to`.
    """

    gap_y: float = defect_param(0.003, "m", "lateral play", (0.0, 0.02))
    gap_z: float = defect_param(0.0013, "m", "vertical play", (0.0, 0.02))
    load_from: float = defect_param(
        1300.0, "N", "load where the road begins to sink", (0.0, 10000.0)
    )
    load_to: float = defect_param(2900.0, "N", "load where it rests again", (1.0, 20000.0))
    friction: float = defect_param(40.0, "N", "holds the road sideways", (0.0, 2000.0))

    source = "thesis 3.1, hardware issue 9; figure G.5"
    touches = frozenset({"fy", "fz"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["support_gap_y"], m["support_gap_z"] = self.gap_y, self.gap_z
        m["support_from"] = self.load_from
        m["support_to"] = max(self.load_to, self.load_from + 1.0)
        m["support_friction"] = self.friction
