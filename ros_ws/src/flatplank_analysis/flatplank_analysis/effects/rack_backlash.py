# SPDX-License-Identifier: Apache-2.0
"""Backlash of rack and pinion."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect
from flatplank_analysis.effects.lost_motion import lost_motion


@dataclass(frozen=True)
class RackBacklash(TireEffect):
    """After a change of the slip the plank goes along with the wheel until the teeth have
    crossed the gap.

    Source: thesis 6.3: about 0.64 mm, together with the drive the plateau of 0.75 mm
    """

    identifier = "rack_backlash"
    title = "Backlash of rack and pinion"
    kind = "machine"
    coordinate = "slip travel"
    source = "thesis 6.3: about 0.64 mm, together with the drive the plateau of 0.75 mm"
    what = (
        "The teeth of rack and pinion cross their gap when the force on the plank changes: "
        "the plank goes along with the tire and the force stays what it was. The pinion "
        "encoder does not see it."
    )
    check = "Second encoder on the plank itself; dial gauge on the plank while the pinion is held."
    removes = "Adjust the engagement of the pinion, or a second, preloaded pinion."

    gap: float = param(
        0.0,
        unit="m",
        bounds=(0.0, 3e-3),
        screen=3e-4,
        matters=1e-4,
        note="lost motion of the plank",
    )

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 2.5)

    def motion(self, motion: Motion) -> None:
        motion.travel += lost_motion(motion, self.gap)
