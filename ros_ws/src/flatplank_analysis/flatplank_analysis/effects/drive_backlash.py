# SPDX-License-Identifier: Apache-2.0
"""After a change of the slip the wheel goes on as before until the gears have crossed the gap."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect
from flatplank_analysis.effects.lost_motion import lost_motion


@dataclass(frozen=True)
class DriveBacklash(TireEffect):
    """After a change of the slip the wheel goes on as before until the gears have crossed the
    gap.

    Source: thesis 6.3, figure 6.7: dead travel times slip is constant
    """

    identifier = "drive_backlash"
    title = "Backlash of the wheel drive"
    kind = "machine"
    coordinate = "slip travel"
    source = "thesis 6.3, figure 6.7: dead travel times slip is constant"
    what = (
        "Gears of the wheel drive cross their gap when the torque reverses: the drive turns, "
        "the wheel waits. Dead travel after the step times the slip is the gap."
    )
    check = (
        "Lock the wheel, reverse a small torque and read the motor encoder; compare motor and "
        "wheel encoder over a reversed step; look at the first 0.1 m after a 1 % step."
    )
    removes = "Preloaded gears, or a pre-turn of the motor by the gap before the step."

    gap: float = param(
        0.0,
        unit="m",
        bounds=(0.0, 3e-3),
        screen=3e-4,
        matters=1e-4,
        note="lost motion at the road",
    )

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 2.5)

    def motion(self, motion: Motion) -> None:
        motion.rolled -= lost_motion(motion, self.gap)
