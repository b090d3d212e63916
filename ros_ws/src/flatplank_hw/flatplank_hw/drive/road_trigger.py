# SPDX-License-Identifier: Apache-2.0
"""Trigger output of a drive for an optical system: a pulse of one cycle at equal distances of
road, or constantly on while armed."""

from __future__ import annotations

import math

SHORTEST = 1e-5
"""shortest distance of two pulses [m]: less than a count of the plank's encoder"""
BIT = 1
"""bit of the trigger in the digital outputs"""


class RoadTrigger:
    """Road trigger; `step` returns the digital outputs of a cycle."""

    __slots__ = ("_distance", "_next", "armed", "pulses")

    def __init__(self) -> None:
        self.armed = False
        self.pulses = 0
        """pulses since it was armed"""
        self._distance = self._next = math.nan

    def arm(self, distance: float) -> None:
        """Arm: a pulse every `distance` [m] of road; 0: constantly on."""
        self.armed, self.pulses = True, 0
        self._distance, self._next = distance, math.nan

    def disarm(self) -> None:
        self.armed = False

    def step(self, position: float, moving: bool) -> int:
        """Digital outputs for a plank at `position` [m]."""
        if not self.armed:
            return 0
        if self._distance <= 0.0:
            self.pulses = max(self.pulses, 1)
            return BIT
        if not moving:
            return 0
        # the motion trigger may set the position to zero during the motion
        if not abs(self._next - position) <= 1.5 * self._distance:
            self._next = math.ceil(position / self._distance) * self._distance
        if position < self._next:
            return 0
        self._next += self._distance
        self.pulses += 1
        return BIT
