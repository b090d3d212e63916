# SPDX-License-Identifier: Apache-2.0
"""Bus guard: the last check before commands are sent. While the bench has a fault, no command to
move is sent.

A stop is latched. Only a rising edge of the fault reset bit clears it, once its cause is gone.
Until then the axis shows the state FAULT with the error code of the cause, like a drive.
"""

from __future__ import annotations

from enum import IntEnum

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital, Health
from flatplank_hw.cia402 import (
    DISABLE_VOLTAGE,
    ENABLE_OPERATION,
    ENERGISED,
    FAULT_RESET,
    FAULT_STATUS,
    QUICK_STOP,
    SHUTDOWN,
    STATE_BITS,
    STATUS,
    SWITCH_ON,
    State,
    decode,
)

BRAKING_S = 0.25
"""duration of the quick stop before the voltage is disabled [s]"""


class Cause(IntEnum):
    """Reason why an axis is held; the value is an error code of CiA 402 or of its maker range."""

    NONE = 0x0000
    BUS = 0x7500
    STALE_COMMAND = 0x8130
    EMERGENCY_STOP = 0xFF01
    LIMIT_SWITCH = 0xFF02


# status (masked) -> control words (masked) that bring the drive closer to motion
_UPWARD = {
    STATUS[State.SWITCH_ON_DISABLED]: (SHUTDOWN, SWITCH_ON, ENABLE_OPERATION),
    # the same with the quick stop bit, which has no meaning in this state
    STATUS[State.SWITCH_ON_DISABLED] | 0x20: (SHUTDOWN, SWITCH_ON, ENABLE_OPERATION),
    STATUS[State.READY_TO_SWITCH_ON]: (SWITCH_ON, ENABLE_OPERATION),
    STATUS[State.SWITCHED_ON]: (ENABLE_OPERATION,),
}
_STOPPED = (*ENERGISED, State.FAULT_REACTION_ACTIVE, State.FAULT)
"""states from which only a reset leads back to motion, once the guard has seen a cause"""
_LIMITS = {
    AXES.index("wheel"): Digital.LIMIT_FRONT,
    AXES.index("plank"): Digital.LIMIT_FRONT | Digital.LIMIT_REAR,
}
"""limit switches that stop an axis; only the closing edge counts, so that the axis can move back
"""


class Guard:
    """Guard of one bus; call `step` once per cycle."""

    def __init__(self, rate_hz: int, timeout_ms: int) -> None:
        self.timeout = max(timeout_ms * rate_hz // 1000, 1)
        """largest age of a command that is sent [cycles]"""
        self.braking = round(BRAKING_S * rate_hz)
        self.latched: dict[int, Cause] = {}
        self.stops: dict[str, int] = {}
        """cause -> number of stops"""
        self._since: dict[int, int] = {}
        self._reset_seen: dict[int, bool] = {}
        self._digital = ~0

    def step(
        self, cycle: int, commands: dict[int, AxisCommand], inputs: BusInputs | None, health: int
    ) -> list[AxisCommand]:
        """Commands that may be sent in `cycle`; inputs and health are those of the last cycle."""
        common = self._common(inputs, health)
        digital = inputs.digital if inputs is not None else self._digital
        closed, self._digital = digital & ~self._digital, digital
        out = []
        for axis, command in commands.items():
            cause = common or self._own(axis, cycle, command, closed)
            status = self._status(axis, inputs)
            if cause and axis not in self.latched and _must_be_held(status, command.control_word):
                self._latch(axis, cause, cycle)
            reset = bool(command.control_word & FAULT_RESET)
            if reset and not self._reset_seen.get(axis, True) and not cause:
                self.latched.pop(axis, None)
            self._reset_seen[axis] = reset
            if axis in self.latched:
                out.append(_held(command, self._word(axis, cycle)))
            elif cause:
                out.append(_held(command, DISABLE_VOLTAGE))
            else:
                out.append(command)
        return out

    def with_held_axes_in_fault(self, inputs: BusInputs) -> BusInputs:
        """Inputs as the drive nodes see them: a held axis is in FAULT."""
        if not self.latched:
            return inputs
        axes = list(inputs.axes)
        for axis, cause in self.latched.items():
            shown: AxisInputs = axes[axis]
            code = shown.error_code or cause
            axes[axis] = shown._replace(status_word=FAULT_STATUS, error_code=code)
        return inputs._replace(axes=tuple(axes))

    def hold_all(self, cycle: int, cause: Cause) -> None:
        """Stop every axis, for the end of the bus."""
        for axis in range(len(AXES)):
            if axis not in self.latched:
                self._latch(axis, cause, cycle)

    def _common(self, inputs: BusInputs | None, health: int) -> Cause:
        if inputs is None or health not in (Health.OK, Health.DEGRADED):
            return Cause.BUS
        if not inputs.digital & Digital.EMERGENCY_STOP_OK:
            return Cause.EMERGENCY_STOP
        return Cause.NONE

    def _own(self, axis: int, cycle: int, command: AxisCommand, closed: int) -> Cause:
        if cycle - command.cycle > self.timeout:
            return Cause.STALE_COMMAND
        return Cause.LIMIT_SWITCH if closed & _LIMITS.get(axis, 0) else Cause.NONE

    def _latch(self, axis: int, cause: Cause, cycle: int) -> None:
        self.latched[axis] = cause
        self._since[axis] = cycle
        self.stops[cause.name] = self.stops.get(cause.name, 0) + 1

    def _word(self, axis: int, cycle: int) -> int:
        return QUICK_STOP if cycle - self._since[axis] < self.braking else DISABLE_VOLTAGE

    @staticmethod
    def _status(axis: int, inputs: BusInputs | None) -> int:
        if inputs is None:
            return STATUS[State.OPERATION_ENABLED]
        return inputs.axes[axis].status_word & STATE_BITS


def _must_be_held(status: int, word: int) -> bool:
    """True when the drive is energised or in fault, or the command brings it closer to motion.

    A drive that restarts forgets its fault, so that it may be enabled again without a reset.
    """
    return decode(status) in _STOPPED or word & 0x0F in _UPWARD.get(status, ())


def _held(command: AxisCommand, word: int) -> AxisCommand:
    return command._replace(
        control_word=word, target_velocity=0, target_torque=0, digital_outputs=0
    )
