# SPDX-License-Identifier: Apache-2.0
"""What a plan waits for, told from the measured samples alone."""

from __future__ import annotations

import math
from collections.abc import Callable

from flatplank_control.runner.steps import Snapshot

Condition = Callable[[Snapshot], bool]
OPERATION_ENABLED = 4
AT_ANGLE = math.radians(0.2)
STILL = 1e-3
"""wheel speed of a wheel that stands [rad/s]"""


def plank_rests() -> Condition:
    return lambda s: not s.encoders.plank_moving


def plank_moves() -> Condition:
    return lambda s: s.encoders.plank_moving


def plank_beyond(position: float) -> Condition:
    """At `position` [m] after the trigger, or at rest before it: the end of the road."""
    return lambda s: s.encoders.plank_position >= position or not s.encoders.plank_moving


def enabled() -> Condition:
    return lambda s: s.drive.state == OPERATION_ENABLED


def wheel_at(angle_deg: float) -> Condition:
    angle = math.radians(angle_deg)
    return lambda s: abs(s.drive.position - angle) < AT_ANGLE and abs(s.drive.velocity) < STILL


def loaded(fz: float) -> Condition:
    """The load [N] is there, within 1 % and 10 N."""
    return lambda s: abs(s.hub.fz_filtered - fz) < 10.0 + 0.01 * fz


def unloaded() -> Condition:
    return lambda s: abs(s.hub.fz_filtered) < 100.0
