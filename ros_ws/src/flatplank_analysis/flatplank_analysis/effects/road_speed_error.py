# SPDX-License-Identifier: Apache-2.0
"""The road is faster or slower than its encoder says."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect


@dataclass(frozen=True)
class RoadSpeedError(TireEffect):
    """The road is faster or slower than its encoder says: the same slip offset in all runs."""

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
