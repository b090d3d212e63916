# SPDX-License-Identifier: Apache-2.0
"""The steering angle is off by a constant."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect


@dataclass(frozen=True)
class SteeringZero(TireEffect):
    """The steering angle is off by a constant."""

    identifier = "steering_zero"
    title = "Zero error of the steering angle"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis Table I.1: Fy = 0 at 1.0 deg"
    what = (
        "The steering is not straight at its zero. With one direction of travel it cannot be "
        "told from ply steer."
    )
    check = "Straight edge along the rim; reversed run."
    removes = "Set the slip angle offset in the parameters."

    zero: float = param(0.0, unit="rad", bounds=(-0.05, 0.05), screen=2e-3, matters=1e-3)

    def motion(self, motion: Motion) -> None:
        motion.lateral -= self.zero * motion.travel
