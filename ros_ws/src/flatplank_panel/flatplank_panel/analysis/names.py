# SPDX-License-Identifier: Apache-2.0
"""Signals that Runs can draw, and what over: column of the measurement table -> title."""

CHANNELS = {
    "fx": "Fx [N]",
    "fy": "Fy [N]",
    "fz": "Fz [N]",
    "mx": "Mx [N m]",
    "my": "My [N m]",
    "mz": "Mz [N m]",
    "loaded_radius": "loaded radius [m]",
    "wheel_velocity": "wheel speed [rad/s]",
    "plank_velocity": "plank speed [m/s]",
    "motor_torque": "motor torque [N m]",
}
OVER = {
    "plank_position": "road displacement [m]",
    "time": "time [s]",
    "wheel_angle": "wheel angle [rad]",
}
