# SPDX-License-Identifier: Apache-2.0
"""The steering angle follows the pull of the tire through its play."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class SteeringPlay(TireEffect):
    """The steering angle follows the pull of the tire through its play."""

    identifier = "steering_play"
    title = "Play of the steering"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis 3.1: 0.2 deg of play"
    what = (
        "The steering has play: the wheel turns with the pull of the tire until it meets the "
        "other flank."
    )
    check = "Dial gauge at the rim, push and pull at the tire."
    removes = "Clamp the steering during the run."

    play: float = param(
        0.0,
        unit="rad",
        bounds=(0.0, 0.03),
        screen=1.7e-3,
        matters=5e-4,
        note="half of the free angle",
    )

    def tire(self, tire: Tire) -> None:
        tire.y.follow += self.per_run.play
