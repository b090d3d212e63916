# SPDX-License-Identifier: Apache-2.0
"""Samples that the cores exchange: one tuple per cycle, SI units, ISO W axes."""

from __future__ import annotations

from typing import NamedTuple

FOLLOW = "follow"
"""source of the references of a further driven axis"""
SOURCES = ("slip", "free_rolling", FOLLOW)
"""sources of references; the index is the number in the message"""


class Wrench(NamedTuple):
    """Forces [N] and moments [N m] on the tire."""

    fx: float
    fy: float
    fz: float
    mx: float
    my: float
    mz: float


SENSORS = ("C1", "C2", "C3", "C4", "C5", "C6", "LVDT")
"""analog inputs of the hub, in the order of the bits of `HubSample.saturated`"""


def flagged(saturated: int) -> list[str]:
    """Names of the inputs whose bits are set in `HubSample.saturated`."""
    return [name for i, name in enumerate(SENSORS) if saturated >> i & 1]


class HubSample(NamedTuple):
    """Output of the measurement hub."""

    cycle: int
    stamp_ns: int
    wheel: Wrench
    """at the wheel centre, hub axes"""
    contact: Wrench
    """at the contact point, ISO W"""
    loaded_radius: float
    """[m]"""
    total_camber: float
    """hub + road [rad]"""
    fz_filtered: float
    """low-passed vertical force, for the safety rules [N]"""
    filter_on: bool
    saturated: int
    """bit i: channel `SENSORS[i]` is at its limit or gives no number"""


class EncoderSample(NamedTuple):
    """Output of the encoders."""

    cycle: int
    stamp_ns: int
    plank_position: float
    """[m], zero at the motion trigger"""
    plank_velocity: float
    """[m/s]"""
    wheel_angle: float
    """[rad]"""
    wheel_velocity: float
    """[rad/s]"""
    steer_angle: float
    """[rad]"""
    road_camber: float
    """[rad]"""
    road_position: float
    """second road encoder [m]; NaN when not fitted"""
    motor_angle: float
    """wheel-drive motor [rad]"""
    motor_velocity: float
    """[rad/s]"""
    plank_moving: bool
    trigger: bool
    mismatch: float
    """wheel angle by the motor minus wheel angle by the wheel encoder [rad]"""


JOINTS = ("plank", "wheel", "steer", "road_camber")
"""joints that the encoders measure"""
RADIUS_JOINT = "loaded_radius"
"""joint that the measurement hub measures: wheel centre over contact point [m]"""


class Reference(NamedTuple):
    """A set-point for one axis from the source of one operation mode."""

    cycle: int
    stamp_ns: int
    source: str
    """slip, free_rolling, follow"""
    value: float
    """[rad/s] at the wheel, [N m] at the motor or [unit/s] of the axis, by source"""
    valid: bool


class DriveSample(NamedTuple):
    """Output of one drive in addition to its command."""

    cycle: int
    stamp_ns: int
    state: int
    """CiA 402 state"""
    mode: int
    """operation mode of the bench"""
    position: float
    """output side of the gear [rad or m]"""
    velocity: float
    """[rad/s or m/s]"""
    torque: float
    """at the motor [N m]"""
    reference_position: float
    reference_velocity: float
    reference_torque: float
    stop_reason: int
    """why the axis is held, a key of `safety.REASONS`; 0: it is not held"""
    error_code: int
