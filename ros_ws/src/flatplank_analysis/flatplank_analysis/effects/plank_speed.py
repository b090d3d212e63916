# SPDX-License-Identifier: Apache-2.0
"""Errors of the plank speed."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Tire, TireEffect


@dataclass(frozen=True)
class RoadSpeedError(TireEffect):
    """The road is faster or slower than its encoder says: the same slip offset in all runs.

    Source: thesis 6.3: 0.03092 against 0.03096 m/s is -0.13 % of slip
    """

    identifier = "road_speed_error"
    title = "Mean error of the road speed"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis 6.3: 0.03092 against 0.03096 m/s is -0.13 % of slip"
    what = (
        "A wrong pitch radius or gear in the road encoder gives the same slip offset in all runs."
    )
    check = (
        "Measure the plank travel with a tape or a laser over the whole length; compare with "
        "the encoder. In these runs it cannot be told from the effective rolling radius."
    )
    removes = "The right pinion pitch radius in the parameters."

    error: float = param(0.0, unit="1", bounds=(-0.02, 0.02), screen=1e-3, matters=5e-4)

    def motion(self, motion: Motion) -> None:
        motion.travel *= 1.0 + self.error


@dataclass(frozen=True)
class SpeedDroop(TireEffect):
    """The plank loses speed in proportion to the longitudinal force, unseen by its encoder.

    Source: thesis table 6.3: about 0.08 % per kN
    """

    identifier = "speed_droop"
    title = "The plank drive yields to the force"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis table 6.3: about 0.08 % per kN"
    what = (
        "The plank drive gives way under the force. What the encoder on the pinion sees of it "
        "is in the data already; this is what it does not see."
    )
    check = "Second encoder on the plank during a 10 % step."
    removes = "A stiffer speed loop of the plank drive; measured plank position."

    give: float = param(
        0.0,
        unit="1/N",
        bounds=(-4e-6, 4e-6),
        screen=4e-7,
        matters=2e-7,
        note="relative speed per force",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.give += self.per_run.give
