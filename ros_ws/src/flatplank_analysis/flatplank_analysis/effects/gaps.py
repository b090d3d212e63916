# SPDX-License-Identifier: Apache-2.0
"""Gaps in the machine that are crossed when the force or the slip changes: drive, rack, road,
support."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, Signal, Tire, TireEffect


@dataclass(frozen=True)
class Gap(TireEffect):
    """Free travel in the direction of the slip."""

    coordinate = "slip travel"

    gap: float = param(
        0.0, unit="m", bounds=(0.0, 3e-3), screen=3e-4, matters=1e-4,
        title="gap", symbol="δ", note="Lost motion at the road.",
    )  # fmt: skip

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 2.5)


def lost_motion(motion: Motion, gap: np.ndarray) -> np.ndarray:
    """Increments of slip travel [m] that are lost while a gap is crossed, in both directions.

    Relative to free rolling, the output follows the slip travel at a distance of at most the gap
    (play operator); increases of this distance are lost."""
    data = motion.data
    slip = motion.rolled - motion.travel
    before = (data.since_step < -0.004) & (data.since_step > -0.4) & (data.position > 0.05)
    before = np.broadcast_to(before, slip.shape)
    way = np.where(before, motion.travel, 0.0).sum(axis=-1)
    rate = np.where(before, slip, 0.0).sum(axis=-1) / np.maximum(way, 1e-6)
    extra = np.where(data.since_step > 0.0, slip - rate[..., None] * motion.travel, 0.0)
    ahead = np.cumsum(extra, axis=-1)
    gap = np.ascontiguousarray(np.broadcast_to(gap, (*slip.shape[:-1], 1))[..., 0], dtype=float)
    lost = np.empty_like(slip)
    play_distance(ahead, gap, np.zeros(gap.shape), lost)
    return np.diff(lost, axis=-1, prepend=0.0)


@njit(cache=True)
def play_distance(ahead, gap, begin, lost):
    """Play operator: distance of a follower, at most the gap, behind its input (sets, runs,
    samples); begin (sets, runs): position of the follower before the first sample."""
    for i in range(ahead.shape[0]):
        for r in range(ahead.shape[1]):
            output = begin[i, r]
            for n in range(ahead.shape[2]):
                output = min(max(output, ahead[i, r, n] - gap[i, r]), ahead[i, r, n] + gap[i, r])
                lost[i, r, n] = ahead[i, r, n] - output


@dataclass(frozen=True)
class DriveBacklash(Gap):
    """After a change of the slip the wheel keeps its speed until the gears have crossed the
    gap."""

    identifier = "drive_backlash"
    title = "Backlash of the wheel drive"
    source = "thesis 6.3, figure 6.7: dead travel times slip is constant"
    what = (
        "Gears of the wheel drive cross their gap when the torque reverses: the drive turns, "
        "the wheel waits. Dead travel after the step times the slip is the gap."
    )
    check = (
        "Lock the wheel, reverse a small torque and read the motor encoder; compare motor and "
        "wheel encoder over a reversed step."
    )
    shown_by = "The first 0.1 m after a 1 % step."
    removes = "Preloaded gears, or a pre-turn of the motor by the gap before the step."

    def motion(self, motion: Motion) -> None:
        motion.rolled -= lost_motion(motion, self.gap)


@dataclass(frozen=True)
class RackBacklash(Gap):
    """The plank moves with the tire until the teeth have crossed the gap: after a change of
    the slip, or, where the bearings hold it, once the force exceeds their friction."""

    identifier = "rack_backlash"
    title = "Backlash of rack and pinion"
    source = "thesis 6.3: about 0.64 mm, together with the drive the plateau of 0.75 mm"
    what = (
        "The teeth of rack and pinion cross their gap when the force on the plank changes: "
        "the plank goes along with the tire and the force stays what it was. The pinion "
        "encoder does not see it."
    )
    check = "Second encoder on the plank itself; dial gauge on the plank while the pinion is held."
    removes = "Adjust the engagement of the pinion, or a second, preloaded pinion."

    rest: float = param(
        0.0, unit="-", bounds=(-1.0, 1.0),
        title="place in the gap", symbol="r_0",
        note="Held plank: where in the gap a run begins, from the braking to the driving side.",
    )  # fmt: skip
    at: float = param(
        0.0, unit="N", bounds=(-150.0, 150.0),
        title="force of the crossing", symbol="F_δ", note="Held plank: force at which it moves.",
    )  # fmt: skip
    held_fast: float = param(
        0.0, unit="-", bounds=(0.0, 1.0),
        title="held plank", symbol="b_h",
        note="1: the friction of the bearings holds the plank; 0: it does not.",
    )  # fmt: skip

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


@dataclass(frozen=True)
class RoadPlay(Gap):
    """The plank slides through its play while the force crosses zero."""

    identifier = "road_play"
    title = "Play of the road in x"
    source = "thesis 3.1 and 7.2: 1.15 mm of longitudinal play, cut to 0.05 mm later"
    what = (
        "The plank can slide by the gap between its drive and its stop. The force of the tire "
        "holds it on one side; when the force changes its sign the plank crosses the gap and "
        "the force rests at zero meanwhile. Dry friction may keep it where the last run left it: "
        "then repeats of one condition begin on either side of the gap."
    )
    check = (
        "Dial gauge between plank and rack, push and pull the plank by hand with the drive locked."
    )
    shown_by = "A driving step out of a driving preload: no dead travel."
    removes = "Shim or preload the coupling between plank and rack; or keep the force on one side."

    rest: float = param(
        0.0, unit="-", bounds=(-1.0, 1.0),
        title="place in the gap", symbol="r_0",
        note="Where in the gap a run begins, from the braking to the driving side; with `kept` "
        "the first run.",
    )  # fmt: skip
    at: float = param(
        0.0, unit="N", bounds=(-150.0, 150.0),
        title="force of the crossing", symbol="F_δ",
        note="Force at which the plate moves: its dry friction.",
    )  # fmt: skip
    kept: float = param(
        0.0, unit="-", bounds=(0.0, 1.0),
        title="kept place", symbol="b_k",
        note="1: a run begins where the one before it left the plank, held by dry friction; 0: "
             "each run begins at `rest`.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"kept": k, "at": at} for k in (0.0, 1.0) for at in (0.0, 50.0)]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 4

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("kept",)

    def tire(self, tire: Tire) -> None:
        own, x, before = self.per_run, tire.x, tire.data.side_before
        kept = own.kept > 0.5
        x.play += own.gap
        x.play_rest += np.where(kept & (before != 0.0), before, own.rest)
        x.play_at = np.where(kept, 0.0, own.at)
        x.play_hold = np.where(kept, np.abs(own.at), 0.0)


@dataclass(frozen=True)
class SupportPlayY(TireEffect):
    """The support slides sideways through its play while the lateral force crosses zero."""

    identifier = "support_play_y"
    title = "Play of the support in y"
    coordinate = "distance since the step"
    source = "thesis 3.1: 3 mm in y"
    what = (
        "The rotation support has side play: small lateral forces do not build up until it is "
        "taken up."
    )
    check = "Dial gauge at the support, push sideways."
    removes = "New bearings of the rotation support."

    gap: float = param(
        0.0, unit="m", bounds=(0.0, 6e-3), screen=5e-4, matters=2e-4,
        title="side play", symbol="δ_y", note="Sideways play of the support.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.y.play += self.per_run.gap


@dataclass(frozen=True)
class SupportPlayZ(TireEffect):
    """The axle drops or rises by its play when the longitudinal force changes sides."""

    identifier = "support_play_z"
    title = "Play of the support in z"
    coordinate = "slip level"
    source = "thesis 3.1: 1.3 mm in z"
    what = (
        "The support has play in z: the torque reaction moves the axle from one side to the "
        "other, and the load with it."
    )
    check = "Dial gauge at the axle during a change from braking to driving."
    removes = "New bearings of the rotation support."

    gap: float = param(
        0.0, unit="m", bounds=(-2e-3, 2e-3), screen=2e-4, matters=1e-4,
        title="play in height", symbol="δ_z",
        note="Change of the axle height between braking and driving.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        # vertical stiffness of the tire, thesis Table 7.2
        side = np.tanh(signal.true_fx / 200.0)
        signal.fz = signal.fz + 0.5 * 2.13e5 * self.gap * side
