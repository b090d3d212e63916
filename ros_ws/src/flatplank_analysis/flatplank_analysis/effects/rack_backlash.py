# SPDX-License-Identifier: Apache-2.0
"""Backlash of rack and pinion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, Tire
from flatplank_analysis.effects.gap import Gap
from flatplank_analysis.effects.lost_motion import lost_motion


@dataclass(frozen=True)
class RackBacklash(Gap):
    """The plank goes along with the tire until the teeth have crossed the gap: after a change of
    the slip, or, where the bearings hold it, once the force is beyond their friction.
    """

    identifier = "rack_backlash"
    title = "Backlash of rack and pinion"
    kind = "machine"
    source = "thesis 6.3: about 0.64 mm, together with the drive the plateau of 0.75 mm"
    what = (
        "The teeth of rack and pinion cross their gap when the force on the plank changes: "
        "the plank goes along with the tire and the force stays what it was. The pinion "
        "encoder does not see it."
    )
    check = "Second encoder on the plank itself; dial gauge on the plank while the pinion is held."
    removes = "Adjust the engagement of the pinion, or a second, preloaded pinion."

    rest: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 1.0),
        note="held plank: where in the gap a run starts, -1 braking side, +1 driving side",
    )
    at: float = param(
        0.0, unit="N", bounds=(-150.0, 150.0), note="held plank: force at which it moves"
    )
    held_fast: float = param(
        0.0, unit="1", bounds=(0.0, 1.0), note="1: the friction of the bearings holds the plank"
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"held_fast": 0.0}, {"held_fast": 1.0}, {"held_fast": 1.0, "at": 50.0}]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 3

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("held_fast",)

    def motion(self, motion: Motion) -> None:
        motion.travel += lost_motion(motion, self.gap * (1.0 - self.held_fast))

    def tire(self, tire: Tire) -> None:
        own = self.per_run
        tire.x.play += own.gap * own.held_fast
        tire.x.play_rest += own.rest * own.held_fast
        tire.x.play_at += own.at * own.held_fast
