# SPDX-License-Identifier: Apache-2.0
"""The friction differs between braking and driving."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class DriveBrakeAsymmetry(TireEffect):
    """The friction differs between braking and driving.

    Source: thesis 6.3: tires respond differently to drive and brake slip
    """

    identifier = "drive_brake_asymmetry"
    title = "Less friction when braking than when driving"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3: tires respond differently to drive and brake slip"
    what = (
        "The tire grips less in one direction; or the load falls when braking, unseen by the hub."
    )
    check = (
        "Turn the tire on the rim: the difference goes with the tire, or stays with the machine."
    )
    removes = "Nothing when it is the tire; a load control when it is the load."

    less: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 0.4),
        screen=0.04,
        matters=0.01,
        note="relative loss of friction when braking",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.asym_peak += self.per_run.less
