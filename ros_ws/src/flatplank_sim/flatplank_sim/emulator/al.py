# SPDX-License-Identifier: Apache-2.0
"""The AL state machine of a slave (ETG.1000.6): INIT, PREOP, SAFEOP, OP and errors."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

ERROR = 0x10
ACKNOWLEDGE = 0x10


class State(IntEnum):
    """AL states as in the registers."""

    INIT = 1
    PREOP = 2
    BOOT = 3
    SAFEOP = 4
    OP = 8


class AlStatusCode(IntEnum):
    """AL status codes that the emulator sets without an injected fault."""

    NONE = 0x0000
    INVALID_CHANGE = 0x0011
    UNKNOWN_STATE = 0x0012
    NO_BOOT = 0x0013
    INVALID_MAILBOX = 0x0016
    WATCHDOG = 0x001B
    INVALID_OUTPUTS = 0x001D
    INVALID_INPUTS = 0x001E


_UP = {(State.INIT, State.PREOP), (State.PREOP, State.SAFEOP), (State.SAFEOP, State.OP)}


class StateMachine:
    """AL state machine; it checks each request and reports each change to its owner."""

    def __init__(
        self, check: Callable[[State], int], changed: Callable[[State, State], None]
    ) -> None:
        """check(target) returns an AL status code (0: allowed); changed(old, new) is called after
        a change."""
        self.state = State.INIT
        self.error = False
        self.code = 0
        self.refused: dict[State, int] = {}
        """injected faults: state that the slave refuses -> AL status code"""
        self._check = check
        self._changed = changed

    @property
    def status(self) -> int:
        """AL status register."""
        return self.state | (ERROR if self.error else 0)

    def reset(self) -> None:
        """Reset to the state after power-on."""
        old, self.state, self.error, self.code = self.state, State.INIT, False, 0
        self._changed(old, State.INIT)

    def request(self, control: int) -> None:
        """Handle a write to AL control. An error must be acknowledged before a higher state is
        allowed."""
        if self.error and not control & ACKNOWLEDGE and control & 0x0F >= self.state:
            return
        self.error, self.code = False, 0
        try:
            target = State(control & 0x0F)
        except ValueError:
            self._fail(AlStatusCode.UNKNOWN_STATE)
            return
        code = self._verdict(target)
        if code:
            self._fail(code)
        elif target != self.state:
            self._go(target)

    def drop(self, target: State, code: int) -> None:
        """Let the slave fall back to a state by itself, with an error code."""
        if target < self.state:
            self._go(target)
        self._fail(code)

    def _verdict(self, target: State) -> int:
        if target == State.BOOT:
            return AlStatusCode.NO_BOOT
        if target in self.refused:
            return self.refused[target]
        if target <= self.state:
            return AlStatusCode.NONE
        if (self.state, target) not in _UP:
            return AlStatusCode.INVALID_CHANGE
        return self._check(target)

    def _go(self, target: State) -> None:
        old, self.state = self.state, target
        self._changed(old, target)

    def _fail(self, code: int) -> None:
        self.error, self.code = True, int(code)
