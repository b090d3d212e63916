# SPDX-License-Identifier: Apache-2.0
"""The process image: raw inputs and commands of one bus cycle, for any kind of bus.

These are plain tuples for speed: bench and twin make and read them at every cycle.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple

AXES = ("wheel", "plank", "steer", "vertical", "camber")
"""order of the drives in every image; the index of an axis here is its number on the bus"""


class Digital(IntFlag):
    """Bits of the digital inputs."""

    TRIGGER = 1
    EMERGENCY_STOP_OK = 2
    LIMIT_FRONT = 4
    LIMIT_REAR = 8


class Health(IntEnum):
    """Health of the bus, determined by the owner of the bus and published with every image.

    DEGRADED: single frames are lost, and bridged. STALE: the answers are of an older cycle. LOST:
    no answer of all slaves for more than two cycles. SLAVE_FAULT: a slave is not in OP.
    """

    OK = 0
    DEGRADED = 1
    STALE = 2
    LOST = 3
    SLAVE_FAULT = 4


class AxisInputs(NamedTuple):
    """Process data from one CiA 402 drive."""

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
    """optional second road encoder, whose measuring wheel rolls on the road"""
    digital: int
    health: int
    axes: tuple[AxisInputs, ...]


CHANNELS = 6
"""number of bridge channels"""
PER_CYCLE = BusInputs._fields[3:-2]
"""fields of `BusInputs` with one number per cycle of a batch"""


class AxisCommand(NamedTuple):
    """Command of one drive node to its axis, in answer to the inputs of `cycle`."""

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
