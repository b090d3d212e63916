# SPDX-License-Identifier: Apache-2.0
"""Digital output of a drive as trigger of an optical system: on for one cycle every so much road,
or on as long as it is armed."""

from __future__ import annotations

import math

BIT = 1
"""of the digital outputs"""


class RoadTrigger:
    """`step` tells the digital outputs of a cycle."""

    __slots__ = ("_distance", "_next", "armed", "pulses")

    def __init__(self) -> None:
        self.armed = False
        self.pulses = 0
        """rising edges since it was armed"""
        self._distance = self._next = math.nan

    def arm(self, distance: float) -> None:
        """A pulse each `distance` [m] of road; 0: a level for as long as it is armed."""
        self.armed, self.pulses = True, 0
        self._distance, self._next = distance, math.nan

    def disarm(self) -> None:
        self.armed = False

    def step(self, position: float, moving: bool) -> int:
        """Outputs for a plank at `position` [m]."""
        if not self.armed:
            return 0
        if self._distance <= 0.0:
            self.pulses = max(self.pulses, 1)
            return BIT
        if not moving:
            return 0
        # the motion trigger sets the position to zero on the way
        if not abs(self._next - position) <= 1.5 * self._distance:
            self._next = math.ceil(position / self._distance) * self._distance
        if position < self._next:
            return 0
        self._next += self._distance
        self.pulses += 1
        return BIT
