# SPDX-License-Identifier: Apache-2.0
"""A rig whose motor lags, and how long it turns."""

from __future__ import annotations

import math
from collections.abc import Callable

from drive_rig import PERIOD, Rig

from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES

CODE = RULES["following_error"].code
SPEED = 0.1


class Slow(Rig):
    """A motor that reacts late and speeds up or brakes slowly, at rest still later."""

    late = 0
    """cycles until a set-point acts"""
    slowest = math.inf
    """acceleration [unit/s^2]"""
    kept = None
    deaf_to: Callable[[int], bool] = staticmethod(lambda mode: False)
    """modes whose set-points no longer act: the last one stays"""

    def obey(self, c) -> None:
        if self.deaf_to(c.mode):
            c = self.kept._replace(control_word=c.control_word)
        self.kept = c
        before = self.velocity
        if self.state is State.OPERATION_ENABLED and self.late:
            self.late -= 1
            c = c._replace(target_velocity=0, target_torque=0, mode=9)
        start = self.counts
        super().obey(c)
        most = self.slowest * PERIOD * 1e-9
        self.velocity = before + min(max(self.velocity - before, -most), most)
        self.counts = start + self.velocity * self.scale * PERIOD * 1e-9


def rolling(mode: str = "slip", value: float = SPEED, make: type = Slow, **parameters) -> Slow:
    """A motor that follows."""
    rig = make(**parameters)
    rig.run(2)
    assert rig.drive.set_operation_mode(mode, value).accepted
    assert rig.drive.enable().accepted
    rig.run(20, until=lambda s: s.state == State.OPERATION_ENABLED)
    if mode in ("slip", "free_rolling"):
        rig.load()
        rig.source, rig.reference = mode, value
        rig.plank(True)
    return rig


def seconds_to(rig: Rig, code: int, most: float = 2.0) -> float:
    """Time until the axis stops for a reason [s]."""
    first = rig.n
    rig.run(round(most / (PERIOD * 1e-9)), until=lambda s: s.stop_reason == code)
    return (rig.n - first) * PERIOD * 1e-9
