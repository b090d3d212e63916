# SPDX-License-Identifier: Apache-2.0
"""The six operation modes of thesis chapter 4, and `follow`; a new mode is a class in `MODES`."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

from flatplank_data.limits import Limit
from flatplank_hw.bus.image import AxisInputs
from flatplank_hw.cia402 import (
    ENABLE_OPERATION,
    HOMING_ATTAINED,
    HOMING_ERROR,
    HOMING_START,
    CiaMode,
)
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.safety import NS

_NAN = math.nan
_ANSWER_CYCLES = 4
"""Shortest delay from a command to its effect in the inputs [cycles]."""


class Move:
    """Trapezoidal move to `target`: position and velocity in units of the output."""

    __slots__ = ("acceleration", "position", "speed", "target", "velocity")

    def __init__(self, speed: float, acceleration: float) -> None:
        self.speed = speed
        self.acceleration = acceleration
        self.position = self.target = self.velocity = 0.0

    def stand(self, position: float) -> None:
        """Set the move to rest at `position`."""
        self.position = self.target = position
        self.velocity = 0.0

    def step(self, dt: float) -> None:
        """Advance by dt [s]; the move ends exactly on the target."""
        left = self.target - self.position
        change = self.acceleration * dt
        if left == 0.0 and self.velocity == 0.0:
            return
        if abs(left) <= change * dt and abs(self.velocity) <= 2.0 * change:
            self.stand(self.target)
            return
        # largest speed, one step ahead, from which the remaining distance suffices to stop
        allowed = (
            math.sqrt((0.5 * change) ** 2 + 2.0 * self.acceleration * abs(left)) - 0.5 * change
        )
        wanted = math.copysign(min(self.speed, allowed), left)
        self.velocity += min(max(wanted - self.velocity, -change), change)
        self.position += self.velocity * dt


class SetPoint(NamedTuple):
    """Set-point of a mode; NaN: not in force."""

    cia_mode: int
    position: float
    """at the output [unit]"""
    velocity: float
    """at the output [unit/s]"""
    torque: float
    """at the motor [N m]"""


STAND = SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, 0.0, _NAN)
"""set-point of a held axis in any mode: zero speed"""


class Mode:
    """Base class of the operation modes; a mode overrides the methods that it needs."""

    name: ClassVar[str]
    code: ClassVar[int]
    source: ClassVar[str | None] = None
    """`Reference.source` that the mode follows; None: the mode uses its own value"""
    axes: ClassVar[frozenset[str]] = frozenset()
    """axes that have the source"""

    def __init__(self, p: DriveParameters) -> None:
        self.p = p
        self.limit: Limit | None = None
        """range of the value or of the references of the mode; None: it takes none"""

    def refusal(self, value: float) -> str:
        """Reason why the mode cannot take a value of its own or a reference; empty when it
        can."""
        name = "reference" if self.source else self.name
        return self.limit.refusal(name, value) if self.limit else ""

    def set_value(self, value: float) -> None:
        """Set a value that `refusal` has accepted."""

    def enter(self, position: float) -> None:
        """Start the mode, or restart it after a hold, at rest at `position`."""

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        """Set-point of this cycle; `reference` is 0 without a source."""
        return STAND


class Follow(Mode):
    """Follow the speed of a controller of this axis: load, steering angle, road camber."""

    name, code, source = "follow", 7, "follow"
    axes = frozenset({"steer", "vertical", "camber"})

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.limit = Limit(-p.speed_limit, p.speed_limit, f"{p.unit}/s")

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, reference, _NAN)


class Slip(Follow):
    """Follow the wheel speed of the slip sequencer."""

    name, code, source = "slip", 1, "slip"
    axes = frozenset({"wheel"})


class Position(Mode):
    """Go to a position and hold it."""

    name, code = "position", 2

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.limit = Limit(p.travel_min, p.travel_max, p.unit)
        self.move = Move(p.move_speed, p.acceleration)
        self._target = _NAN

    def set_value(self, value: float) -> None:
        self._target = value

    def enter(self, position: float) -> None:
        self.move.stand(position)
        self._target = _NAN

    @property
    def done(self) -> bool:
        """True when the move is complete."""
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

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.limit = Limit(-p.speed_limit, p.speed_limit, f"{p.unit}/s")

    def set_value(self, value: float) -> None:
        self._wanted = value

    def enter(self, position: float) -> None:
        self._now = 0.0

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        change = self.p.acceleration * dt
        self._now += min(max(self._wanted - self._now, -change), change)
        return SetPoint(CiaMode.CYCLIC_VELOCITY, _NAN, self._now, _NAN)


class Torque(Mode):
    """Apply a constant torque."""

    name, code = "torque", 4
    _wanted = 0.0

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.limit = Limit(-p.torque_limit, p.torque_limit, "N m")

    def set_value(self, value: float) -> None:
        self._wanted = value

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.CYCLIC_TORQUE, _NAN, _NAN, self._wanted)


class FreeRolling(Mode):
    """Follow the motor torque of the free-rolling controller."""

    name, code, source = "free_rolling", 5, "free_rolling"
    axes = frozenset({"wheel"})

    def __init__(self, p: DriveParameters) -> None:
        super().__init__(p)
        self.limit = Limit(-p.torque_limit, p.torque_limit, "N m")

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.CYCLIC_TORQUE, _NAN, _NAN, reference)


class Homing(Mode):
    """Make the present position zero: homing of the drive, then position mode."""

    name, code = "homing", 6

    def step(self, reference: float, position: float, dt: float) -> SetPoint:
        return SetPoint(CiaMode.HOMING, _NAN, _NAN, _NAN)


MODES: dict[str, type[Mode]] = {
    mode.name: mode for mode in (Slip, Position, Velocity, Torque, FreeRolling, Homing, Follow)
}


class HomingSequence:
    """Homing at the present position (CiA 402 method 37): the counter is set to zero, nothing
    moves.

    The sequence is: homing mode, rising edge of bit 4, wait for "attained".
    """

    __slots__ = ("_asked", "_p", "_started", "running")

    def __init__(self, p: DriveParameters) -> None:
        self._p = p
        self.running = False
        self._started = 0
        self._asked = 0

    def start(self, now: int) -> None:
        """Start homing at bench time `now` [ns]."""
        self.running, self._started, self._asked = True, now, 0

    def step(self, axis: AxisInputs, now: int) -> tuple[int, bool, bool]:
        """Control word, whether homing is done, whether it has failed."""
        if not self._p.home_in_drive:
            return self._end(done=True)
        if now - self._started > self._p.start_timeout * NS:
            return self._end(done=False)
        if axis.mode_display != CiaMode.HOMING:
            return ENABLE_OPERATION, False, False
        self._asked += 1
        # the bit of an earlier homing may still be set: wait for its rising edge after our start
        settled = self._asked > 1 + _ANSWER_CYCLES
        if settled and axis.status_word & (HOMING_ERROR | HOMING_ATTAINED):
            return self._end(done=not axis.status_word & HOMING_ERROR)
        return ENABLE_OPERATION | HOMING_START, False, False

    def _end(self, done: bool) -> tuple[int, bool, bool]:
        self.running = False
        return ENABLE_OPERATION, done, not done
