# SPDX-License-Identifier: Apache-2.0
"""After a change of the slip the wheel goes on as before until the gears have crossed the gap."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.effects.base import Motion
from flatplank_analysis.effects.gap import Gap
from flatplank_analysis.effects.lost_motion import lost_motion


@dataclass(frozen=True)
class DriveBacklash(Gap):
    """After a change of the slip the wheel goes on as before until the gears have crossed the
    gap.
    """

    identifier = "drive_backlash"
    title = "Backlash of the wheel drive"
    kind = "machine"
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

    def motion(self, motion: Motion) -> None:
        motion.rolled -= lost_motion(motion, self.gap)
