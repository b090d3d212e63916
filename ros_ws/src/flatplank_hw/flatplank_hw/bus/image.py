# SPDX-License-Identifier: Apache-2.0
"""The process image: what one bus cycle carries, raw, whoever owns the bus.

Plain tuples on purpose: they are made and read at every cycle, on the bench and in the twin.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple

AXES = ("wheel", "plank", "steer", "vertical", "camber")
"""Order of the drives in every image; an axis is known on the bus by its index here."""


class Digital(IntFlag):
    """Bits of the digital inputs."""

    TRIGGER = 1
    EMERGENCY_STOP_OK = 2
    LIMIT_FRONT = 4
    LIMIT_REAR = 8


class Health(IntEnum):
    """What the owner of the bus thinks of the image it publishes."""

    OK = 0
    DEGRADED = 1
    STALE = 2
    LOST = 3
    SLAVE_FAULT = 4


class AxisInputs(NamedTuple):
    """What one CiA 402 drive reports."""

    status_word: int
    mode_display: int
    position: int
    """motor encoder [counts], int32, wraps"""
    velocity: int
    """[counts/s]"""
    torque: int
    """[0.1 mN m]"""
    error_code: int


class BusInputs(NamedTuple):
    """One cycle of raw inputs."""

    cycle: int
    stamp_ns: int
    """bench time of the sample [ns]; cycle times the period on the simulated bench"""
    bridge_volts: tuple[float, float, float, float, float, float]
    """C1..C6 [V]"""
    lvdt_volts: float
    """axle height [V]"""
    plank_counts: int
    """pinion encoder, int32, wraps"""
    wheel_counts: int
    steer_counts: int
    camber_counts: int
    road_counts: int
    """optional second road encoder, rolling on the road itself"""
    digital: int
    health: int
    axes: tuple[AxisInputs, ...]


class AxisCommand(NamedTuple):
    """What one drive node asks of its axis, in answer to the inputs of `cycle`."""

    axis: int
    cycle: int
    control_word: int
    mode: int
    target_position: int
    """[counts], int32, wraps"""
    target_velocity: int
    """[counts/s]"""
    target_torque: int
    """[0.1 mN m]"""
    digital_outputs: int
