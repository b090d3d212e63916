# SPDX-License-Identifier: Apache-2.0
"""Table of the signals on the page, for ring buffer, ribbon and plots."""

from __future__ import annotations

import math
from typing import NamedTuple

DEG = 180.0 / math.pi


class Signal(NamedTuple):
    """One column of the live data."""

    key: str
    label: str
    unit: str
    digits: int


SIGNALS = (
    Signal("t", "Time", "s", 1),
    Signal("x", "Plank position", "m", 4),
    Signal("v", "Plank speed", "m/s", 5),
    Signal("fx", "Fx", "N", 0),
    Signal("fy", "Fy", "N", 0),
    Signal("fz", "Fz", "N", 0),
    Signal("mx", "Mx", "N m", 1),
    Signal("my", "My", "N m", 1),
    Signal("mz", "Mz", "N m", 1),
    Signal("theta", "Wheel angle", "deg", 2),
    Signal("omega", "Wheel speed", "rad/s", 4),
    Signal("steer", "Steering", "deg", 2),
    Signal("camber", "Road camber", "deg", 2),
    Signal("rl", "Loaded radius", "m", 4),
    Signal("pos", "Position", "deg", 2),
    Signal("pos_ref", "Position, reference", "deg", 2),
    Signal("vel", "Velocity", "rad/s", 4),
    Signal("vel_ref", "Velocity, reference", "rad/s", 4),
    Signal("tq", "Torque at the motor", "N m", 3),
    Signal("tq_ref", "Torque, reference", "N m", 3),
    Signal("slip", "Slip", "%", 2),
    Signal("slip_ref", "Slip, reference", "%", 2),
)
"""columns of the ring buffer, in this order"""

BY_KEY = {signal.key: signal for signal in SIGNALS}

RIBBON = (
    ("Force, contact point", {"fx": "Fx", "fy": "Fy", "fz": "Fz"}),
    ("Moment, contact point", {"mx": "Mx", "my": "My", "mz": "Mz"}),
    ("Plank", {"x": "position", "v": "speed"}),
    ("Wheel", {"theta": "angle", "omega": "speed", "rl": "loaded radius"}),
    ("Angles", {"steer": "steering", "camber": "road camber"}),
)
"""groups of the ribbon: title, key -> short name"""

FORCE_PLOTS = ("fx", "fy", "fz", "mx", "my", "mz")
DRIVE_PLOTS = (("pos", "pos_ref"), ("vel", "vel_ref"), ("tq", "tq_ref"))
"""actual value and reference of the wheel drive"""

CHANNELS = {
    "fx": "Fx [N]", "fy": "Fy [N]", "fz": "Fz [N]",
    "mx": "Mx [N m]", "my": "My [N m]", "mz": "Mz [N m]",
    "loaded_radius": "loaded radius [m]", "wheel_velocity": "wheel speed [rad/s]",
    "plank_velocity": "plank speed [m/s]", "motor_torque": "motor torque [N m]",
}  # fmt: skip
"""signals on the page Runs: column of the measurement table -> title"""
OVER = {
    "plank_position": "road displacement [m]",
    "time": "time [s]",
    "wheel_angle": "wheel angle [rad]",
}
"""abscissae on the page Runs: column -> title"""
