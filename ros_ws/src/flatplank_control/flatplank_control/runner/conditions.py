# SPDX-License-Identifier: Apache-2.0
"""What a plan waits for, told from the measured samples alone."""

from __future__ import annotations

import math
from collections.abc import Callable

from flatplank_control.runner.steps import Snapshot
from flatplank_hw.cia402 import State

Condition = Callable[[Snapshot], bool]
AT_ANGLE = math.radians(0.2)
STILL = 1e-3
"""wheel speed of a wheel that stands [rad/s]"""
PRELOAD = 300.0
"""largest force of the preloaded shaft while the parasitic filter is off [N], thesis 3.1"""
RADIUS_STILL = 3e-4
"""of an axle that rests [m]"""
STILL_FOR = 300_000_000
"""[ns]"""


def plank_rests() -> Condition:
    return lambda s: not s.encoders.plank_moving


def plank_moves() -> Condition:
    return lambda s: s.encoders.plank_moving


def travelled(distance: float) -> Condition:
    """The plank has gone so far [m] since the first look, or rests again before."""
    first: float | None = None

    def check(s: Snapshot) -> bool:
        nonlocal first
        if first is None:
            first = s.encoders.plank_position
        gone = abs(s.encoders.plank_position - first)
        return gone >= distance or not s.encoders.plank_moving

    return check


def plank_beyond(position: float) -> Condition:
    """At `position` [m] after the trigger, or at rest before it: the end of the road."""
    return lambda s: s.encoders.plank_position >= position or not s.encoders.plank_moving


class Remembered:
    """A condition that remembers whether it held when it was last asked."""

    def __init__(self, condition: Condition) -> None:
        self._condition = condition
        self.held = False

    def __call__(self, s: Snapshot) -> bool:
        self.held = self._condition(s)
        return self.held


def enabled() -> Condition:
    return lambda s: s.drive.state == State.OPERATION_ENABLED


def wheel_at(angle_deg: float) -> Condition:
    angle = math.radians(angle_deg)
    return lambda s: abs(s.drive.position - angle) < AT_ANGLE and abs(s.drive.velocity) < STILL


def loaded(fz: float, zero: float = math.nan) -> Condition:
    """The load [N] is there, within 1 % and 10 N.

    `zero`: force of the unloaded hub at this wheel angle [N]. Without it the largest force of the
    preloaded shaft is allowed for.
    """
    known = not math.isnan(zero)

    def check(s: Snapshot) -> bool:
        hidden = 0.0 if known or s.hub.filter_on else PRELOAD
        offset = zero if known else 0.0
        return abs(s.hub.fz_filtered - offset - fz) < 10.0 + 0.01 * fz + hidden

    return check


def unloaded() -> Condition:
    """Hardly any force, and the axle has come to rest."""
    radius, since = math.inf, 0

    def check(s: Snapshot) -> bool:
        nonlocal radius, since
        stamp = s.encoders.stamp_ns
        if abs(s.hub.loaded_radius - radius) > RADIUS_STILL:
            radius, since = s.hub.loaded_radius, stamp
        still = stamp - since >= STILL_FOR
        return still and abs(s.hub.fz_filtered) < 100.0 + PRELOAD

    return check
