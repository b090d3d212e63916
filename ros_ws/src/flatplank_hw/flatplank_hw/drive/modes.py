# SPDX-License-Identifier: Apache-2.0
"""The six operation modes of thesis chapter 4, and `follow`; a new mode is a class in `MODES`."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

from flatplank_hw.bus.image import AxisInputs
from flatplank_hw.cia402 import (
    ENABLE_OPERATION,
    HOMING_ATTAINED,
    HOMING_ERROR,
    HOMING_START,
    CiaMode,
)
from flatplank_hw.drive.params import DriveParameters

NS = 1_000_000_000
_NAN = math.nan
_ANSWER_CYCLES = 4
"""A command is answered at the earliest after the delay of the loop."""


class Move:
    """Position and velocity on the way to `target`, all in units of the output."""

    __slots__ = ("acceleration", "position", "speed", "target", "velocity")

    def __init__(self, speed: float, acceleration: float) -> None:
        self.speed = speed
        self.acceleration = acceleration
        self.position = self.target = self.velocity = 0.0

    def stand(self, position: float) -> None:
        """Be at rest at a position."""
        self.position = self.target = position
        self.velocity = 0.0

    def step(self, dt: float) -> None:
        """Go on by dt [s]; ends exactly on the target."""
        left = self.target - self.position
        change = self.acceleration * dt
        if left == 0.0 and self.velocity == 0.0:
            return
        if abs(left) <= change * dt and abs(self.velocity) <= 2.0 * change:
            self.stand(self.target)
            return
        # the speed from which the rest of the way is just enough to stop, a step ahead
        allowed = (
            math.sqrt((0.5 * change) ** 2 + 2.0 * self.acceleration * abs(left)) - 0.5 * change
        )
        wanted = math.copysign(min(self.speed, allowed), left)
        self.velocity += min(max(wanted - self.velocity, -change), change)
        self.position += self.velocity * dt


class SetPoint(NamedTuple):
    """What a mode asks for; NaN: not in force."""

    cia_mode: int
    position: float
    """[unit] of the output"""
    velocity: float
    """[unit/s] of the output"""
    torque: float
    """[N m] at the motor"""


STAND = SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, 0.0, _NAN)
"""Zero speed: how every mode is held."""


class Mode:
    """Hooks with identity defaults; a mode overrides what it needs."""

    name: ClassVar[str]
    code: ClassVar[int]
    source: ClassVar[str | None] = None
    """`Reference.source` that the mode listens to; None: its own value"""

    def __init__(self, p: DriveParameters) -> None:
        self.p = p

    def refuse(self, value: float) -> str | None:
        """Why a value cannot be taken, or None."""
        return None

    def set_value(self, value: float) -> None:
        """Take a value that was not refused."""

    def enter(self, position: float) -> None:
        """Begin, or begin again after a hold, at rest at `position`."""

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        """Set-point of this cycle; `reference` is 0 without a source."""
        return STAND


def _limited(value: float, limit: float) -> float:
    return limit if value > limit else -limit if value < -limit else value


def _refuse(what: str, value: float, unit: str, low: float, high: float) -> str | None:
    if not math.isfinite(value):
        return f"{what} is {value}: give a number"
    if not low <= value <= high:
        return f"{what} of {value:g} {unit} is outside {low:g} .. {high:g} {unit}"
    return None


class Follow(Mode):
    """Follow the speed of a controller of this axis: load, steering angle, road camber."""

    name, code, source = "follow", 7, "follow"

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        velocity = _limited(reference, self.p.speed_limit)
        return SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, velocity, _NAN)


class Slip(Follow):
    """Follow the wheel speed of the slip sequencer."""

    name, code, source = "slip", 1, "slip"


class Position(Mode):
    """Go to a position and hold it."""

    name, code = "position", 2

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.move = Move(p.move_speed, p.acceleration)
        self._target = _NAN

    def refuse(self, value: float) -> str | None:
        p = self.p
        return _refuse("position", value, p.unit, p.travel_min, p.travel_max)

    def set_value(self, value: float) -> None:
        self._target = value

    def enter(self, position: float) -> None:
        self.move.stand(position)
        self._target = _NAN

    @property
    def done(self) -> bool:
        """The move has come to its end."""
        return math.isnan(self._target) and self.move.position == self.move.target

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        if not math.isnan(self._target):
            self.move.target, self._target = self._target, _NAN
        self.move.step(dt)
        return SetPoint(CiaMode.CYCLIC_POSITION, self.move.position, self.move.velocity, _NAN)


class Velocity(Mode):
    """Turn at a constant speed."""

    name, code = "velocity", 3
    _wanted = _now = 0.0

    def refuse(self, value: float) -> str | None:
        p = self.p
        return _refuse("velocity", value, f"{p.unit}/s", -p.speed_limit, p.speed_limit)

    def set_value(self, value: float) -> None:
        self._wanted = value

    def enter(self, position: float) -> None:
        self._now = 0.0

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        self._now += _limited(self._wanted - self._now, self.p.acceleration * dt)
        return SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, self._now, _NAN)


class Torque(Mode):
    """Apply a constant torque."""

    name, code = "torque", 4
    _wanted = 0.0

    def refuse(self, value: float) -> str | None:
        limit = self.p.torque_limit
        return _refuse("torque", value, "N m", -limit, limit)

    def set_value(self, value: float) -> None:
        self._wanted = value

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.CYCLIC_TORQUE, _NAN, _NAN, self._wanted)


class FreeRolling(Mode):
    """Follow the motor torque of the free-rolling controller."""

    name, code, source = "free_rolling", 5, "free_rolling"

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        torque = _limited(reference, self.p.torque_limit)
        return SetPoint(CiaMode.CYCLIC_TORQUE, _NAN, _NAN, torque)


class Homing(Mode):
    """Make the present position zero; the axis goes through the drive's own homing and then to
    position."""

    name, code = "homing", 6

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.HOMING, _NAN, _NAN, _NAN)


MODES: dict[str, type[Mode]] = {
    mode.name: mode for mode in (Slip, Position, Velocity, Torque, FreeRolling, Homing, Follow)
}


class Homer:
    """Homing where the axis stands (CiA 402 method 37): the counter is set to zero, nothing moves.

    Homing mode, rising edge of bit 4, wait for "attained".
    """

    __slots__ = ("_asked", "_p", "_started", "running")

    def __init__(self, p: DriveParameters) -> None:
        self._p = p
        self.running = False
        self._started = 0
        self._asked = 0

    def start(self, now: int) -> None:
        """Begin at bench time `now` [ns]."""
        self.running, self._started, self._asked = True, now, 0

    def step(self, axis: AxisInputs, now: int) -> tuple[int, bool, bool]:
        """Control word, done, failed."""
        if not self._p.home_in_drive:
            return self._end(done=True)
        if now - self._started > self._p.start_timeout * NS:
            return self._end(done=False)
        if axis.mode_display != CiaMode.HOMING:
            return ENABLE_OPERATION, False, False
        self._asked += 1
        # the bit of an earlier homing may still be set: only the edge after our start counts
        settled = self._asked > 1 + _ANSWER_CYCLES
        if settled and axis.status_word & (HOMING_ERROR | HOMING_ATTAINED):
            return self._end(done=not axis.status_word & HOMING_ERROR)
        return ENABLE_OPERATION | HOMING_START, False, False

    def _end(self, done: bool) -> tuple[int, bool, bool]:
        self.running = False
        return ENABLE_OPERATION, done, not done
