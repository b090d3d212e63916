# SPDX-License-Identifier: Apache-2.0
"""Inflation pressure acts otherwise than the file says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class GripOverPressure(SweepEffect):
    """Friction changes with the pressure over the nominal one.

    Source: Besselink, Schmeitz, Pacejka (2010), An improved Magic Formula/Swift tyre model, PPY3.
    """

    identifier = "grip_pressure"
    title = "friction follows the inflation pressure"
    kind = "tire"
    coordinate = "pressure"
    needs = ("pressure",)
    in_file = True
    what = "the tire file has no pressure, or another one"
    check = "sweep at three pressures"
    removes = "fit PPX3 and PPY3 to sweeps at several pressures"
    slope: float = param(
        0.0, unit="1", bounds=(-2.0, 2.0), screen=0.05, matters=0.01,
        title="friction over pressure", symbol="q_μp",
        note="Relative change of the friction over that of the pressure.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.grip = s.grip * (1.0 + self.slope * (s.pressure / s.nominal.NOMPRES - 1.0))


@dataclass(frozen=True)
class StiffnessOverPressure(SweepEffect):
    """Slip stiffness changes with the pressure over the nominal one.

    Source: Besselink, Schmeitz, Pacejka (2010), An improved Magic Formula/Swift tyre model, PPY1.
    """

    identifier = "stiffness_pressure"
    title = "slip stiffness follows the inflation pressure"
    kind = "tire"
    coordinate = "pressure"
    needs = ("pressure",)
    in_file = True
    what = "the tire file has no pressure, or another one"
    check = "sweep at three pressures"
    removes = "fit PPX1 and PPY1 to sweeps at several pressures"
    slope: float = param(
        0.0, unit="1", bounds=(-2.0, 2.0), screen=0.05, matters=0.01,
        title="slip stiffness over pressure", symbol="q_Kp",
        note="Relative change of the slip stiffness over that of the pressure.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.stiffness = s.stiffness * (1.0 + self.slope * (s.pressure / s.nominal.NOMPRES - 1.0))
