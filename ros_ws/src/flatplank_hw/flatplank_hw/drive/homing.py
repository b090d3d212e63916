# SPDX-License-Identifier: Apache-2.0
"""Homing where the axis stands (CiA 402 method 37): the counter is set to zero, nothing moves."""

from __future__ import annotations

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


class Homer:
    """Homing mode, rising edge of bit 4, wait for "attained"."""

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
            self.running = False
            return ENABLE_OPERATION, True, False
        if now - self._started > self._p.start_timeout * NS:
            self.running = False
            return ENABLE_OPERATION, False, True
        if axis.mode_display != CiaMode.HOMING:
            return ENABLE_OPERATION, False, False
        self._asked += 1
        # the bit of an earlier homing may still be set: only the edge after our start counts
        settled = self._asked > 1 + _ANSWER_CYCLES
        if settled and axis.status_word & HOMING_ERROR:
            self.running = False
            return ENABLE_OPERATION, False, True
        if settled and axis.status_word & HOMING_ATTAINED:
            self.running = False
            return ENABLE_OPERATION, True, False
        return ENABLE_OPERATION | HOMING_START, False, False


_ANSWER_CYCLES = 4
"""A command is answered at the earliest after the delay of the loop."""
