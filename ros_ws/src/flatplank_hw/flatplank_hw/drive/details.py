# SPDX-License-Identifier: Apache-2.0
"""What was measured when a safety rule applied, for people."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from flatplank_hw.bus.image import Health
from flatplank_hw.drive.safety import Situation

if TYPE_CHECKING:
    from flatplank_hw.drive.params import DriveParameters

MS = 1e-6
"""[ms/ns]"""


def _inputs(s: Situation, p: DriveParameters) -> str:
    health = Health(s.health).name.lower().replace("_", " ")
    return f"bus {health}, {s.gap_ns * MS:.0f} ms since the inputs before"


def _road(s: Situation, p: DriveParameters) -> str:
    return f"plank at {s.plank_position:.3f} m of {p.road_length:g} m"


DETAILS: dict[str, Callable[[Situation, DriveParameters], str]] = {
    "inputs": _inputs,
    "samples": lambda s, p: f"the older one is {s.sample_age_ns * MS:.0f} ms old",
    "heartbeat": lambda s, p: f"for {s.heartbeat_age_ns * MS:.0f} ms",
    "speed": lambda s, p: f"{s.speed:.3g} {p.unit}/s, limit {p.speed_trip:g} {p.unit}/s",
    "torque": lambda s, p: f"limit {p.torque_trip:g} N m at the motor",
    "fz": lambda s, p: f"{s.fz:.0f} N, limit {p.fz_trip:.0f} N",
    "road_end": _road,
    "steering": lambda s, p: (
        f"{math.degrees(s.steer_angle):.1f} deg, limit {p.steering_limit_deg:g} deg"
    ),
    "plank_stopped": _road,
    "reference": lambda s, p: f"{s.reference_age_ns * MS:.0f} ms old",
    "reference_gone": lambda s, p: f"for {s.reference_age_ns * MS:.0f} ms",
    "drag": lambda s, p: (
        f"Fz {s.fz:.0f} N, plank at {s.plank_position:.3f} m and {1e3 * s.plank_velocity:.1f} mm/s"
    ),
}
"""trouble -> its numbers; a trouble without any is not here"""


def detail(name: str, s: Situation, p: DriveParameters) -> str:
    """The numbers of a trouble; empty when it has none."""
    say = DETAILS.get(name)
    return say(s, p) if say else ""
