# SPDX-License-Identifier: Apache-2.0
"""Safety rules of a drive: pure functions of the situation, each registered in `_RULES`.

A latching rule stops the axis until the drive is enabled again; a holding rule keeps it at zero
speed while it applies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from flatplank_hw.bus.image import Digital, Health
from flatplank_hw.cia402 import State
from flatplank_hw.drive.params import RULE_CODES, DriveParameters
from flatplank_hw.troubles import TROUBLES

NS = 1_000_000_000
"""[ns/s]"""
REVERSE_SPEED = -0.0005
"""the plank moves backward below this velocity [m/s]; its slow speed is 0.0015 m/s"""
_EMERGENCY_OK = int(Digital.EMERGENCY_STOP_OK)
_STALE = int(Health.STALE)


@dataclass
class Situation:
    """Inputs of the rules: plain numbers of one cycle, prepared by the drive."""

    health: int = 0
    gap_ns: int = 0
    """time since the previous inputs"""
    digital: int = _EMERGENCY_OK
    state: int = State.SWITCH_ON_DISABLED
    sample_age_ns: int = 0
    """age of the older of the hub and encoder samples"""
    follows_reference: bool = False
    """the mode follows the references of a source (of any axis), not a value of its own"""
    reference_age_ns: int = 0
    """age of the last good reference, at most the time since the plank started"""
    refused: str = ""
    """why the newest reference was refused; empty when it was not"""
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
    """time above the trip value"""
    torque_high_ns: int = 0
    speed: float = 0.0
    """at the output [unit/s]"""
    claimed: bool = False
    heartbeat_age_ns: int = 0
    following_error: float = 0.0
    """commanded minus measured travel since the drive obeyed last [unit]"""
    following_limit: float = math.inf
    """largest error at the present speed [unit]"""
    torque_off_ns: int = 0
    """time for which the measured torque is not the commanded one"""
    wheel_left: bool = False
    """the drive of the wheel has left operation since this axis was enabled"""


Check = Callable[[Situation, DriveParameters], bool]


class Rule(NamedTuple):
    """One rule: `check` is true when the axis must not move, also for NaN."""

    name: str
    """name of the rule and of its trouble"""
    latching: bool
    check: Check

    @property
    def code(self) -> int:
        """Stop reason of the rule."""
        return RULE_CODES[self.name]

    @property
    def text(self) -> str:
        """Text for the operator."""
        return TROUBLES[self.name].text


def unloaded(s: Situation, p: DriveParameters) -> bool:
    """True when the tire is clear of the road, with the clearance and almost no force."""
    clear = s.loaded_radius > p.free_radius + p.unloaded_clearance
    return clear and -p.unloaded_fz < s.fz < p.unloaded_fz


def may_turn(s: Situation, p: DriveParameters) -> bool:
    """True when the road moves, or the tire is unloaded and the mode needs no moving plank."""
    return s.moving or (not s.follows_reference and unloaded(s, p))


def heartbeat_gone(s: Situation, p: DriveParameters) -> bool:
    return s.claimed and s.heartbeat_age_ns > p.heartbeat_timeout * NS


def reference_gone(s: Situation, p: DriveParameters) -> bool:
    """True when the last reference is too old."""
    return s.follows_reference and s.reference_age_ns > p.reference_timeout * NS


def does_not_follow(s: Situation, p: DriveParameters) -> bool:
    """True when the motor is too far from its commands, or its torque is for too long."""
    limit = s.following_limit
    return not -limit <= s.following_error <= limit or s.torque_off_ns > p.following_time * NS


_RULES = (
    Rule(
        "inputs", True,
        lambda s, p: s.health >= _STALE or not 0 <= s.gap_ns <= p.input_timeout * NS,
    ),
    Rule("samples", True, lambda s, p: s.sample_age_ns > p.input_timeout * NS),
    Rule("drive_fault", True, lambda s, p: s.state >= State.FAULT_REACTION_ACTIVE),
    Rule("emergency_stop", True, lambda s, p: not s.digital & _EMERGENCY_OK),
    Rule("heartbeat", True, heartbeat_gone),
    Rule("speed", True, lambda s, p: not -p.speed_trip <= s.speed <= p.speed_trip),
    Rule("torque", True, lambda s, p: s.torque_high_ns > p.trip_time * NS),
    Rule("fz", True, lambda s, p: s.fz_high_ns > p.trip_time * NS),
    Rule(
        "road_end", True,
        lambda s, p: not s.plank_position <= p.road_length and not unloaded(s, p),
    ),
    Rule(
        "steering", True,
        lambda s, p: not abs(s.steer_angle) <= math.radians(p.steering_limit_deg),
    ),
    Rule("plank_stopped", True, lambda s, p: s.turning and not may_turn(s, p)),
    Rule("plank_stands", False, lambda s, p: not may_turn(s, p)),
    Rule(
        "plank_reverses", False,
        lambda s, p: s.follows_reference and not s.plank_velocity >= REVERSE_SPEED,
    ),
    # for the wheel, which needs references only while the plank moves
    Rule("reference", True, lambda s, p: s.moving and reference_gone(s, p)),
    Rule("reference_gone", True, reference_gone),
    # for the plank: a stopped wheel would be dragged over the moving road
    Rule("wheel_stopped", True, lambda s, p: s.wheel_left and not unloaded(s, p)),
    Rule("following_error", True, does_not_follow),
)  # fmt: skip

RULES: dict[str, Rule] = {rule.name: rule for rule in _RULES}

QUICK_STOP = 20
LEFT_OPERATION = 21
NO_ANSWER = 22

STOPS: dict[int, str] = {
    **{code: name for name, code in RULE_CODES.items()},
    QUICK_STOP: "quick_stop",
    LEFT_OPERATION: "left_operation",
    NO_ANSWER: "no_answer",
}
"""stop reason of a `DriveSample` -> its trouble"""

REASONS: dict[int, str] = {0: "", **{code: TROUBLES[name].text for code, name in STOPS.items()}}
"""stop reason -> text; 0: the axis is not held"""

HOLDING = frozenset(rule.code for rule in _RULES if not rule.latching)
"""stop reasons that end by themselves; all others stay until the drive is enabled again"""


def is_latched(code: int) -> bool:
    """True for a stop reason that stays until the drive is enabled again."""
    return code != 0 and code not in HOLDING


def first_stop(rules: tuple[Rule, ...], s: Situation, p: DriveParameters) -> Rule | None:
    """First rule that applies, or None."""
    for rule in rules:
        if rule.check(s, p):
            return rule
    return None


MS = 1e-6
"""[ms/ns]"""


def _inputs(s: Situation, p: DriveParameters) -> str:
    health = Health(s.health).name.lower().replace("_", " ")
    return f"bus {health}, {s.gap_ns * MS:.0f} ms since the inputs before"


def _road(s: Situation, p: DriveParameters) -> str:
    return f"plank at {s.plank_position:.3f} m of {p.road_length:g} m"


def _reference(s: Situation, p: DriveParameters) -> str:
    text = f"the last good one is {s.reference_age_ns * MS:.0f} ms old"
    return f"{text}, {s.refused}" if s.refused else text


def _following(s: Situation, p: DriveParameters) -> str:
    if s.torque_off_ns:
        return f"the torque is not the commanded one for {s.torque_off_ns * MS:.0f} ms"
    return f"{s.following_error:.3g} {p.unit}, limit {s.following_limit:.3g} {p.unit}"


DETAILS: dict[str, Callable[[Situation, DriveParameters], str]] = {
    "inputs": _inputs,
    "samples": lambda s, p: f"the older sample is {s.sample_age_ns * MS:.0f} ms old",
    "heartbeat": lambda s, p: f"for {s.heartbeat_age_ns * MS:.0f} ms",
    "speed": lambda s, p: f"{s.speed:.3g} {p.unit}/s, limit {p.speed_trip:g} {p.unit}/s",
    "torque": lambda s, p: f"limit {p.torque_trip:g} N m at the motor",
    "fz": lambda s, p: f"{s.fz:.0f} N, limit {p.fz_trip:.0f} N",
    "road_end": _road,
    "steering": lambda s, p: (
        f"{math.degrees(s.steer_angle):.1f} deg, limit {p.steering_limit_deg:g} deg"
    ),
    "plank_stopped": _road,
    "reference": _reference,
    "reference_gone": _reference,
    "following_error": _following,
    "drag": lambda s, p: (
        f"Fz {s.fz:.0f} N, plank at {s.plank_position:.3f} m and {1e3 * s.plank_velocity:.1f} mm/s"
    ),
}
"""trouble -> text with its numbers, for troubles that have numbers"""


def trouble_detail(name: str, s: Situation, p: DriveParameters) -> str:
    """Text with the numbers of a trouble; empty when it has none."""
    describe = DETAILS.get(name)
    return describe(s, p) if describe else ""
