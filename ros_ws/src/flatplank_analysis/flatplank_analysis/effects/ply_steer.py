# SPDX-License-Identifier: Apache-2.0
"""The belt steers."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect


@dataclass(frozen=True)
class PlySteer(TireEffect):
    """The belt steers: a lateral force at zero slip angle that turns with the direction of
    travel.
    """

    identifier = "ply_steer"
    title = "Ply steer"
    kind = "tire"
    rarity = 1
    coordinate = "slip level"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The cords of the belt make the tire roll at an angle."
    check = "Reversed run: ply steer changes its sign, conicity does not."
    removes = "Nothing: it belongs to the tire."

    angle: float = param(0.0, unit="rad", bounds=(-0.02, 0.02), screen=1e-3, matters=5e-4)

    def motion(self, motion: Motion) -> None:
        motion.lateral += self.angle * motion.travel
