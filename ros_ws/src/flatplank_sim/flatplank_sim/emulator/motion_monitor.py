# SPDX-License-Identifier: Apache-2.0
"""Monitors the true motion of the plant's shafts and the power stages, independent of the bus."""

from __future__ import annotations

from typing import Any

from flatplank_hw.bus.image import AXES, BusInputs
from flatplank_hw.cia402 import State, decode

WHEEL_MOVING = 0.002
"""the wheel turns above this speed; its usual speed is 0.1 [rad/s]"""
MOVING = 800
"""a motor turns above this speed [counts per cycle]"""


class MotionMonitor:
    """Registers when each motor shaft last moved, and how many times each power stage was
    enabled."""

    def __init__(self) -> None:
        self.last_moving = [-1] * len(AXES)
        """bench time of the last motion [ns]; -1: never"""
        self.enabled = [False] * len(AXES)
        self.enables = [0] * len(AXES)
        self.last_fault = -1
        """bench time at which the last fault was injected [ns]"""
        self.last_frame = -1
        """bench time of the last process data frame [ns]"""
        self.left_op = -1
        """bench time at which a slave has last left OP [ns]; -1: never"""
        self.now = 0
        self._in_op = False
        self._position: list[int | None] = [None] * len(AXES)

    def register_cycle(
        self, now: int, inputs: BusInputs, wheel_speed: float | None = None
    ) -> None:
        """Register one cycle of the plant's true inputs, before any firmware changes them.

        wheel_speed: speed of the wheel itself, behind gear and backlash [rad/s]; None: use the
        motor.
        """
        self.now = now
        for i, axis in enumerate(inputs.axes):
            before = self._position[i]
            if before is not None:
                step = (axis.position - before + 2**31) % 2**32 - 2**31
                turning = abs(step) > MOVING
                if i == 0 and wheel_speed is not None:
                    turning = abs(wheel_speed) > WHEEL_MOVING
                if turning:
                    self.last_moving[i] = now
            self._position[i] = axis.position
            on = decode(axis.status_word) is State.OPERATION_ENABLED
            if on and not self.enabled[i]:
                self.enables[i] += 1
            self.enabled[i] = on

    def register_states(self, now: int, in_op: bool) -> None:
        """Register whether all slaves are in OP."""
        if self._in_op and not in_op:
            self.left_op = now
        self._in_op = in_op

    def fault(self, now: int) -> None:
        """Register an injected fault."""
        self.last_fault = now

    def report(self) -> dict[str, Any]:
        """Per axis: moving now, ms from last fault to last motion, enabled, times enabled."""
        axes = {}
        for i, name in enumerate(AXES):
            ran_on = self.last_moving[i] - self.last_fault
            axes[name] = {
                "moving": self.last_moving[i] >= 0 and self.now - self.last_moving[i] <= 0,
                "ran_on_ms": max(ran_on, 0) / 1e6 if self.last_fault >= 0 else None,
                "last_moving_ns": self.last_moving[i],
                "still_ms": (self.now - self.last_moving[i]) / 1e6,
                "enabled": self.enabled[i],
                "enables": self.enables[i],
            }
        return {
            "now_ns": self.now, "fault_ns": self.last_fault, "last_frame_ns": self.last_frame,
            "left_op_ns": self.left_op, "axes": axes,
        }  # fmt: skip
