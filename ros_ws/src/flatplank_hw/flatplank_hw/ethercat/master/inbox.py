# SPDX-License-Identifier: Apache-2.0
"""Commands that arrived since the last cycle: the newest counts, but no fault reset gets lost."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.cia402 import FAULT_RESET


class Inbox:
    """The reset bit acts by its edge: in a burst it would be overwritten before any drive saw
    it."""

    def __init__(self) -> None:
        self.current: dict[int, AxisCommand] = {}
        """command in force per axis"""
        self._later: dict[int, AxisCommand] = {}

    def take(self, commands: Iterable[AxisCommand]) -> dict[int, AxisCommand]:
        """What holds in this cycle."""
        waiting, self._later = self._later, {}
        shown: set[int] = set()
        for command in (*waiting.values(), *commands):
            axis = command.axis
            if axis in shown:
                self._later[axis] = command
                continue
            before = self.current.get(axis)
            self.current[axis] = command
            starts = command.control_word & FAULT_RESET
            if starts and not (before is not None and before.control_word & FAULT_RESET):
                shown.add(axis)
        return self.current
