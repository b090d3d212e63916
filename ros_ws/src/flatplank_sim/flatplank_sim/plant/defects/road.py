# SPDX-License-Identifier: Apache-2.0
"""Defects of the road and its plank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class RoadPlay(Defect):
    """The road plate can shift in its plank, because a bearing was lost when the end was
    shortened.

    The play is a gap along the travel; the tire pushes the plate across it when fx changes sign:
    dead travel * kappa = gap.
    """

    gap: float = defect_param(0.00115, "m", "whole play of the road", (0.0, 0.01), "road_gap")
    friction: float = defect_param(
        20.0, "N", "holds the road in its plank", (0.0, 2000.0), "road_friction"
    )

    source = "thesis 3.1, hardware issue 8"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class PlankWander(Defect):
    """The plank moves sideways along its travel, because its guide bearings are misaligned.

    The lateral motion is a sine over the plank position.
    """

    amplitude: float = defect_param(0.0005, "m", "lateral", (0.0, 0.01), "wander")
    period: float = defect_param(1.3, "m", "travel of one wave", (0.01, 20.0), "wander_period")
    phase: float = defect_param(0.0, "rad", "at the start position", into="wander_phase")

    source = "thesis 3.1, hardware issue 11"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})


@dataclass(frozen=True)
class RoadSpeedError(Defect):
    """The road does not run at the speed that the slip control assumes.

    `relative`: the drive is too fast, which the pinion encoder measures; `unseen`: the pitch
    radius is wrong, which it does not.
    """

    relative: float = defect_param(
        0.0013, "-", "speed over nominal speed, less one", (-0.2, 0.2), "speed_error"
    )
    unseen: float = defect_param(
        0.0, "-", "travel over what the encoder says, less one", (-0.2, 0.2), "scale_error"
    )

    source = "thesis 6.3: 0.03096 m/s against 0.03092 m/s"
    touches = frozenset({"fx", "plank_counts"})
    spares = frozenset({"steer_counts", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class WornPatches(Defect):
    """Patches of the sandpaper that have lost their grip.

    Friction is lower at fixed road positions; it acts on each bristle at its own position, and the
    effect grows with |slip|.
    """

    positions: tuple[float, ...] = defect_param(
        (0.15, 2.35, 3.90), "m", "of road travel since the trigger"
    )
    factor: float = defect_param(0.85, "-", "friction there over elsewhere", (0.05, 2.0))
    length: float = defect_param(0.08, "m", "of a patch", (0.005, 2.0))

    source = "thesis 5.6"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        x = site.positions()
        for centre in self.positions:
            edge = np.clip((0.5 * self.length - np.abs(x - centre)) / 0.01 + 0.5, 0.0, 1.0)
            site.road_map[:, 0] *= 1.0 - (1.0 - self.factor) * edge
        site.use_map()


@dataclass(frozen=True)
class SandpaperWear(Defect):
    """The sandpaper wears from run to run.

    Friction falls in proportion to the number of runs since the plant was made.
    """

    per_run: float = defect_param(0.0005, "1/run", "loss of friction", (0.0, 0.2), "wear")

    source = "thesis 3.1, hardware issue 13"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})
