# SPDX-License-Identifier: Apache-2.0
"""Lost motion in the drives: the slip waits until a gap is crossed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect


def lost_motion(motion: Motion, gap: np.ndarray) -> np.ndarray:
    """Increments of slip travel [m] that are lost while a gap is crossed, both ways.

    The slip travel beyond that of free rolling drags its output behind it at a distance of at
    most the gap (play operator); what the distance grows by is lost.
    """
    data = motion.data
    slip = motion.rolled - motion.travel
    before = (data.since_step < -0.004) & (data.since_step > -0.4) & (data.position > 0.05)
    before = np.broadcast_to(before, slip.shape)
    way = np.where(before, motion.travel, 0.0).sum(axis=-1)
    rate = np.where(before, slip, 0.0).sum(axis=-1) / np.maximum(way, 1e-6)
    extra = np.where(data.since_step > 0.0, slip - rate[..., None] * motion.travel, 0.0)
    ahead = np.cumsum(extra, axis=-1)
    gap = np.broadcast_to(gap, (*slip.shape[:-1], 1))[..., 0]
    lost = np.zeros_like(slip)
    output = np.zeros(slip.shape[:-1])
    for n in range(slip.shape[-1]):
        output = np.clip(output, ahead[..., n] - gap, ahead[..., n] + gap)
        lost[..., n] = ahead[..., n] - output
    return np.diff(lost, axis=-1, prepend=0.0)


@dataclass(frozen=True)
class DriveBacklash(TireEffect):
    """After a change of the slip the wheel goes on as before until the gears have crossed the gap.

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


@dataclass(frozen=True)
class RackBacklash(TireEffect):
    """After a change of the slip the plank goes along with the wheel until the teeth have crossed the gap.

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
