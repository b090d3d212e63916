# SPDX-License-Identifier: Apache-2.0
"""A move with limited speed and acceleration, one step per cycle."""

from __future__ import annotations

import math


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
