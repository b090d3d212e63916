# SPDX-License-Identifier: Apache-2.0
"""Tables of CiA 402 for drives, bus guard and simulated drives: status word -> state; state and
goal -> control word; modes; units of the bus."""

from __future__ import annotations

from enum import IntEnum


class State(IntEnum):
    """States of a drive; a status word that matches none counts as NOT_READY."""

    NOT_READY = 0
    SWITCH_ON_DISABLED = 1
    READY_TO_SWITCH_ON = 2
    SWITCHED_ON = 3
    OPERATION_ENABLED = 4
    QUICK_STOP_ACTIVE = 5
    FAULT_REACTION_ACTIVE = 6
    FAULT = 7


class Goal(IntEnum):
    """State to which a drive is to be brought."""

    DISABLED = 0
    ENABLED = 1
    QUICK_STOP = 2
    RESET = 3


class CiaMode(IntEnum):
    """The modes of operation (6060h) that the bench uses."""

    PROFILE_POSITION = 1
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    CYCLIC_POSITION = 8
    CYCLIC_VELOCITY = 9
    CYCLIC_TORQUE = 10


PATTERNS = (
    (0x4F, 0x00, State.NOT_READY),
    (0x4F, 0x40, State.SWITCH_ON_DISABLED),
    (0x6F, 0x21, State.READY_TO_SWITCH_ON),
    (0x6F, 0x23, State.SWITCHED_ON),
    (0x6F, 0x27, State.OPERATION_ENABLED),
    (0x6F, 0x07, State.QUICK_STOP_ACTIVE),
    (0x4F, 0x0F, State.FAULT_REACTION_ACTIVE),
    (0x4F, 0x08, State.FAULT),
)
"""(mask, value, state): the state when status & mask == value."""

STATUS: dict[State, int] = {state: value for _, value, state in PATTERNS}
"""state -> status word, state bits only"""
ENERGISED = (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)
"""states of a drive that follows a set-point or brakes"""
FAULT_STATUS = 0x0218
"""status word of a stopped drive: fault, voltage enabled, remote"""
TORQUE_UNIT = 1e-4
"""[N m] per unit of the torques on the bus"""

STATE_BITS = 0x6F
HOMING_START = 0x10
"""bit 4 of the control word in homing mode"""
HOMING_ATTAINED = 0x1000
"""bit 12 of the status word in homing mode"""
HOMING_ERROR = 0x2000
"""bit 13 of the status word in homing mode"""

DISABLE_VOLTAGE = 0x00
QUICK_STOP = 0x02
SHUTDOWN = 0x06
SWITCH_ON = 0x07
ENABLE_OPERATION = 0x0F
FAULT_RESET = 0x80


def _match(word: int) -> State:
    for mask, value, state in PATTERNS:
        if word & mask == value:
            return state
    return State.NOT_READY


_STATES = tuple(_match(word) for word in range(STATE_BITS + 1))


def decode(status_word: int) -> State:
    """State of a status word."""
    return _STATES[status_word & STATE_BITS]


def in_operation(status_word: int) -> bool:
    """True when a drive follows its set-point."""
    return decode(status_word) is State.OPERATION_ENABLED


_REST = {
    State.NOT_READY: DISABLE_VOLTAGE,
    State.SWITCH_ON_DISABLED: DISABLE_VOLTAGE,
    State.READY_TO_SWITCH_ON: SHUTDOWN,
    State.SWITCHED_ON: SHUTDOWN,
    State.OPERATION_ENABLED: SHUTDOWN,
    State.QUICK_STOP_ACTIVE: DISABLE_VOLTAGE,
    State.FAULT_REACTION_ACTIVE: DISABLE_VOLTAGE,
    State.FAULT: DISABLE_VOLTAGE,
}

TRANSITIONS: dict[Goal, dict[State, int]] = {
    Goal.DISABLED: _REST,
    Goal.ENABLED: {
        **_REST,
        State.SWITCH_ON_DISABLED: SHUTDOWN,
        State.READY_TO_SWITCH_ON: SWITCH_ON,
        State.SWITCHED_ON: ENABLE_OPERATION,
        State.OPERATION_ENABLED: ENABLE_OPERATION,
    },
    Goal.QUICK_STOP: {
        **_REST,
        State.OPERATION_ENABLED: QUICK_STOP,
        State.QUICK_STOP_ACTIVE: QUICK_STOP,
    },
    Goal.RESET: {**_REST, State.FAULT: FAULT_RESET},
}
"""Control word for the next transition towards a goal. The rising edge of bit 7 resets a fault, so
a cycle with another goal must come before and after."""


def control_word(state: State, goal: Goal) -> int:
    """Control word that brings a drive in `state` one transition closer to `goal`."""
    return TRANSITIONS[goal][state]


ERROR_CODES = {
    0x2310: "too much current",
    0x3210: "voltage of the DC link too high",
    0x3220: "voltage of the DC link too low",
    0x4210: "the drive is too hot",
    0x7121: "the motor is blocked",
    0x7305: "fault of the motor's encoder",
    0x7500: "no communication: the watchdog has tripped, or the bus is bad",
    0x8130: "the commands of the drive's node are too old",
    0x8611: "following error",
    0xFF01: "the emergency stop circuit is open",
    0xFF02: "a limit switch was run into",
}
"""error code (603Fh; our guard uses the manufacturer-specific range) -> text"""


def error_words(code: int) -> str:
    """Text of an error code."""
    return f"0x{code:04X}, {ERROR_CODES.get(code, 'see the manual of the drive')}"
