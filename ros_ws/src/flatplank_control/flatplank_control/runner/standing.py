# SPDX-License-Identifier: Apache-2.0
"""Measurements beside slip: stiffnesses, a locked wheel, a cleat, parking, turning."""

from __future__ import annotations

from collections.abc import Iterator

from flatplank_control.runner import conditions as when
from flatplank_control.runner.measurement import DIRECTIONS, SLOW, SPEED, Measurement
from flatplank_control.runner.moves import (
    back_unloaded,
    go_back,
    over_the_road,
    rolling_freely,
    to_rest,
)
from flatplank_control.runner.steps import (
    Arm,
    AxisProfile,
    Enable,
    Manual,
    Plank,
    Quick,
    Record,
    Say,
    Step,
    StopRecord,
    Wait,
)

Plan = Iterator[Step]
STANDS_AT = 0.15
"""machine position of a plank under a standing tire, behind the motion trigger [m]"""
CLEAT_AT = 2.0
"""machine position of the cleat [m]"""
PAUSE = 0.5
"""of rest before a standing tire is loaded sideways [s]"""


def onto_the_road(m: Measurement, room: float = 0.0) -> Plan:
    """The plank stands behind the trigger, so that all of the record is after it.

    `room`: so much farther, for a road that goes back [m].
    """
    yield from back_unloaded(m)
    yield Arm()
    yield Plank(1, stop_at=STANDS_AT + room)
    yield Wait("the plank rests on the road", when.plank_rests(), 30.0, at_least=1.0)
    yield Plank(0)


def _pause() -> Plan:
    yield Wait("the bench rests", lambda _s: True, 2.0 * PAUSE, at_least=PAUSE)


def vertical(m: Measurement) -> Plan:
    """Loading and unloading of the standing tire: C_z from Fz over the loaded radius (G.2)."""
    yield from onto_the_road(m)
    yield Enable(False)
    yield Quick(1)
    yield Record(m.record(), at_once=True)
    yield Say("vertical stiffness: load and unload")
    yield Manual("load", m.fz)
    yield from _pause()
    yield Manual("unload", 0.0)
    yield StopRecord("complete")


def _dragged(m: Measurement, distance: float, fast: bool) -> Plan:
    """The road moves under the wheel that its drive holds."""
    way = DIRECTIONS[m.direction]
    yield from onto_the_road(m, distance if way < 0 else 0.0)
    yield Manual("load", m.fz)
    yield Quick(1)
    yield Record(m.record(), at_once=True)
    yield Say(f"{m.measurement}: the locked wheel over {1e3 * distance:g} mm")
    yield from _pause()
    yield Plank(way, fast=fast)
    yield Wait("the plank moves", when.plank_moves(), 5.0)
    speed = SPEED if fast else SLOW
    patience = 2.0 * distance / speed + 10.0
    yield Wait("the road was dragged", when.travelled(distance), patience, may_end_early=True)
    yield from to_rest()
    yield StopRecord("complete")


def longitudinal(m: Measurement) -> Plan:
    """C_x: Fx over the travel of the road under the standing locked wheel."""
    return _dragged(m, m.distance or 0.006, fast=False)


def lateral(m: Measurement) -> Plan:
    """C_y: the same with the wheel steered; Fy over the travel across the wheel."""
    return _dragged(m, m.distance or 0.008, fast=False)


def locked_wheel(m: Measurement) -> Plan:
    """Friction: the locked wheel until it slides."""
    return _dragged(m, m.distance or 0.3, fast=True)


def cleat(m: Measurement) -> Plan:
    """The tire rolls freely, by its wheel's speed, over a cleat."""
    yield from back_unloaded(m)
    yield Manual("cleat_mm", m.cleat_mm)
    yield Manual("load", m.fz)
    yield from rolling_freely(m)
    yield from over_the_road(m, m.record())
    yield Manual("unload", 0.0)
    yield Manual("cleat_mm", 0.0)


def _duration(m: Measurement) -> float:
    return m.profile_time


def parking(m: Measurement) -> Plan:
    """The standing tire is steered to and fro; needs a driven steering axis."""
    yield from onto_the_road(m)
    yield Manual("load", m.fz)
    yield Enable(False)
    yield Quick(1)
    yield AxisProfile("steer")
    yield Record(m.record(), at_once=True)
    yield Say(f"{m.profile} on the steering axis")
    yield from _pause()
    yield AxisProfile("steer", m.profile, dict(m.profile_parameters))
    time = _duration(m)
    yield Wait("the profile is over", lambda _s: True, time + 5.0, time, may_end_early=True)
    yield StopRecord("complete")
    yield AxisProfile("steer", parameters=None)


def _turned(m: Measurement, axis: str) -> Plan:
    """A profile of an axis under the rolling tire, from the step position on."""
    yield from go_back(m)
    yield AxisProfile(axis)
    yield from rolling_freely(m)
    moves = (AxisProfile(axis, m.profile, dict(m.profile_parameters)),)
    yield from over_the_road(m, m.record(), m.step_position, moves)
    yield AxisProfile(axis, parameters=None)


def turning(m: Measurement) -> Plan:
    """Impulse turning: a short turn of the steering of a rolling tire."""
    return _turned(m, "steer")


def camber_sweep(m: Measurement) -> Plan:
    """The road is tilted under a rolling tire."""
    return _turned(m, "camber")
