# SPDX-License-Identifier: Apache-2.0
"""Safety rules of a drive: small pure questions about the situation, one line of registration
each.

A latching rule stops the axis until somebody enables it again; a holding rule keeps it at zero
speed as long as it applies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from flatplank_hw.bus.image import Digital, Health
from flatplank_hw.drive.cia402 import State

if TYPE_CHECKING:
    from flatplank_hw.drive.params import DriveParameters

NS = 1_000_000_000
REVERSE_SPEED = -0.0005
"""Slower than the plank's slow speed of 0.0015 m/s: a plank that moves back is beyond it [m/s]."""
_EMERGENCY_OK = int(Digital.EMERGENCY_STOP_OK)
_STALE = int(Health.STALE)


@dataclass
class Situation:
    """What the rules see: one cycle, plain numbers, made by the drive."""

    health: int = 0
    gap_ns: int = 0
    """since the inputs before"""
    digital: int = _EMERGENCY_OK
    state: int = State.SWITCH_ON_DISABLED
    sample_age_ns: int = 0
    """of the older one of hub and encoder sample"""
    follows_plank: bool = False
    """the mode listens to a source that follows the plank"""
    reference_age_ns: int = 0
    """of the source's last valid reference, counted from the start of the plank"""
    turning: bool = False
    """the last command asked for motion"""
    moving: bool = False
    """the plank moves"""
    plank_velocity: float = 0.0
    plank_position: float = 0.0
    steer_angle: float = 0.0
    loaded_radius: float = 0.0
    fz: float = 0.0
    """low-passed [N]"""
    fz_high_ns: int = 0
    """for so long above the trip value"""
    torque_high_ns: int = 0
    speed: float = 0.0
    """output side [unit/s]"""
    claimed: bool = False
    heartbeat_age_ns: int = 0


Check = Callable[[Situation, "DriveParameters"], bool]


class Rule(NamedTuple):
    """One rule: `check` is true when the axis must not move; NaN never passes for safe."""

    code: int
    name: str
    text: str
    latching: bool
    check: Check


def unloaded(s: Situation, p: DriveParameters) -> bool:
    """The tire hangs free: over the road by the clearance, and hardly any force."""
    clear = s.loaded_radius > p.free_radius + p.unloaded_clearance
    return clear and -p.unloaded_fz < s.fz < p.unloaded_fz


def may_turn(s: Situation, p: DriveParameters) -> bool:
    """The road moves under the tire, or the tire is free and no source waits for the plank."""
    return s.moving or (not s.follows_plank and unloaded(s, p))


def inputs_bad(s: Situation, p: DriveParameters) -> bool:
    return s.health >= _STALE or s.gap_ns > p.input_timeout * NS


def samples_old(s: Situation, p: DriveParameters) -> bool:
    return s.sample_age_ns > p.input_timeout * NS


def drive_fault(s: Situation, p: DriveParameters) -> bool:
    return s.state >= State.FAULT_REACTION_ACTIVE


def emergency_stop(s: Situation, p: DriveParameters) -> bool:
    return not s.digital & _EMERGENCY_OK


def heartbeat_gone(s: Situation, p: DriveParameters) -> bool:
    return s.claimed and s.heartbeat_age_ns > p.heartbeat_timeout * NS


def too_fast(s: Situation, p: DriveParameters) -> bool:
    return not -p.speed_trip <= s.speed <= p.speed_trip


def torque_high(s: Situation, p: DriveParameters) -> bool:
    return s.torque_high_ns > p.trip_time * NS


def fz_high(s: Situation, p: DriveParameters) -> bool:
    return s.fz_high_ns > p.trip_time * NS


def road_end(s: Situation, p: DriveParameters) -> bool:
    return not s.plank_position <= p.road_length and not unloaded(s, p)


def steered_too_far(s: Situation, p: DriveParameters) -> bool:
    return not abs(s.steer_angle) <= math.radians(p.steering_limit_deg)


def plank_stopped(s: Situation, p: DriveParameters) -> bool:
    return s.turning and not may_turn(s, p)


def plank_stands(s: Situation, p: DriveParameters) -> bool:
    return not may_turn(s, p)


def plank_reverses(s: Situation, p: DriveParameters) -> bool:
    return s.follows_plank and not s.plank_velocity >= REVERSE_SPEED


def reference_gone(s: Situation, p: DriveParameters) -> bool:
    """For an axis that moves whether the plank does or not."""
    return s.follows_plank and s.reference_age_ns > p.reference_timeout * NS


def reference_old(s: Situation, p: DriveParameters) -> bool:
    """For the wheel, whose reference is due only while the plank moves."""
    return s.moving and reference_gone(s, p)


_RULES = (
    Rule(1, "inputs", "inputs of the bus are stale or lost", True, inputs_bad),
    Rule(2, "samples", "hub or encoders have fallen silent", True, samples_old),
    Rule(3, "drive_fault", "the drive reports a fault", True, drive_fault),
    Rule(4, "emergency_stop", "the emergency stop is pressed", True, emergency_stop),
    Rule(5, "heartbeat", "the operator in charge has fallen silent", True, heartbeat_gone),
    Rule(6, "speed", "the axis is faster than its limit", True, too_fast),
    Rule(7, "torque", "the torque is above its limit", True, torque_high),
    Rule(8, "fz", "the vertical force is above its limit", True, fz_high),
    Rule(9, "road_end", "the plank is at the end of the road", True, road_end),
    Rule(10, "steering", "steered so far that the motor hits the pillar", True, steered_too_far),
    Rule(11, "plank_stopped", "the plank stopped under the tire", True, plank_stopped),
    Rule(12, "plank_stands", "the plank stands under the tire: waiting", False, plank_stands),
    Rule(13, "plank_reverses", "the plank moves back: waiting", False, plank_reverses),
    Rule(14, "reference", "the reference is too old or not valid", True, reference_old),
    Rule(15, "reference_gone", "the axis's controller has fallen silent", True, reference_gone),
)

RULES: dict[str, Rule] = {rule.name: rule for rule in _RULES}

QUICK_STOP = 20
LEFT_OPERATION = 21
NO_ANSWER = 22

REASONS: dict[int, str] = {
    0: "",
    **{rule.code: rule.text for rule in _RULES},
    QUICK_STOP: "quick stop was asked for",
    LEFT_OPERATION: "the drive left operation by itself",
    NO_ANSWER: "the drive did not answer in time",
}
"""Text of every stop reason that a `DriveSample` can carry."""


def first_stop(rules: tuple[Rule, ...], s: Situation, p: DriveParameters) -> Rule | None:
    """The first rule that applies."""
    for rule in rules:
        if rule.check(s, p):
            return rule
    return None
