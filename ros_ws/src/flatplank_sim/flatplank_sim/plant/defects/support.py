# SPDX-License-Identifier: Apache-2.0
"""Defects of the supports of plank, wheel and hub."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class SupportBearings(Defect):
    """The plank rises and falls where it rolls onto or off a vertical support bearing.

    The road has humps at fixed plank positions; with a fixed axle height they change the load and
    thereby fx.
    """

    positions: tuple[float, ...] = defect_param(
        (2.1, 2.9, 3.2), "m", "of road travel since the trigger"
    )
    heights: tuple[float, ...] = defect_param(
        (1.2e-4, -1.5e-4, 2.0e-4), "m", "of each hump, one for all if single", (-0.01, 0.01)
    )
    length: float = defect_param(0.10, "m", "of a hump", (0.01, 2.0))

    source = "thesis 6.3, figure 6.6"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def check(self) -> str | None:
        if len(self.heights) in (1, len(self.positions)):
            return None
        return (
            f"{len(self.heights)} heights for {len(self.positions)} positions; "
            "give one height for all or one each"
        )

    def install(self, site: Site) -> None:
        x = site.positions()
        heights = self.heights * (len(self.positions) if len(self.heights) == 1 else 1)
        for centre, height in zip(self.positions, heights, strict=True):
            u = np.clip((x - centre) / (0.5 * self.length), -1.0, 1.0)
            site.road_map[:, 1] += 0.5 * height * (1.0 + np.cos(np.pi * u))
        site.use_map()


@dataclass(frozen=True)
class ParasiticShaft(Defect):
    """The flexplate drum preloads the measuring shaft, which gives spurious forces in the bridges.

    The forces vary once per turn of the wheel, independent of slip and load.
    """

    fx: float = defect_param(
        250.0, "N", "amplitude in Fx at the wheel centre", (0.0, 5000.0), "para_fx"
    )
    fz: float = defect_param(
        250.0, "N", "amplitude in Fz at the wheel centre", (0.0, 5000.0), "para_fz"
    )
    phase: float = defect_param(0.4, "rad", "at wheel angle zero", into="para_phase")

    source = "thesis appendix C, figure C.1"
    touches = frozenset({"fx", "fz"})
    spares = frozenset(
        {"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy", "fx_true"}
    )


@dataclass(frozen=True)
class LoadChange(Defect):
    """The axle height is fixed, not the load: braking lowers it, driving raises it a little.

    fz grows with fx, with different factors for driving and braking.
    """

    brake: float = defect_param(0.0097, "1/kN", "relative load per braking force", (-0.2, 0.2))
    drive: float = defect_param(0.0040, "1/kN", "relative load per driving force", (-0.2, 0.2))

    source = "thesis table 6.3: -3.6 % at -10 %, +1.5 % at +10 %"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["load_brake"], m["load_drive"] = self.brake / 1000.0, self.drive / 1000.0


@dataclass(frozen=True)
class RunOut(Defect):
    """The adapter is not concentric with the hub, which gives run-out once per turn of the wheel.

    Deflection and rolling radius vary with the first order of the wheel angle.
    """

    amplitude: float = defect_param(2e-4, "m", "radial", (0.0, 0.02))
    phase: float = defect_param(0.0, "rad", "wheel angle of the largest radius")
    rolling_share: float = defect_param(0.3, "-", "of it in the rolling radius", (0.0, 2.0))

    source = "thesis 3.1, hardware issue 15"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        m = site.machine
        m["runout"], m["runout_phase"] = self.amplitude, self.phase
        m["runout_rolling"] = self.amplitude * self.rolling_share
