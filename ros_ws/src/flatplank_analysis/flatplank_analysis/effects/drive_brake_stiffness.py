# SPDX-License-Identifier: Apache-2.0
"""The slip stiffness differs between braking and driving."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class DriveBrakeStiffness(TireEffect):
    """The slip stiffness differs between braking and driving.

    Source: thesis 7.1, figure 7.8
    """

    identifier = "drive_brake_stiffness"
    title = "Less slip stiffness when braking than when driving"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 7.1, figure 7.8"
    what = "The tire is softer in one direction."
    check = "Turn the tire on the rim: the difference goes with the tire."
    removes = "Nothing: it belongs to the tire."

    less: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 0.4),
        screen=0.04,
        matters=0.01,
        note="relative loss of slip stiffness when braking",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.asym_stiff += self.per_run.less
