# SPDX-License-Identifier: Apache-2.0
"""Parameters of one drive; the defaults are those of the wheel, other axes have YAML files."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flatplank_data.limits import LIMITS, PILLAR_DEG
from flatplank_data.machine import GEAR_RATIO, USABLE_ROAD
from flatplank_data.names import nearest_hint
from flatplank_data.params import Params, param
from flatplank_hw.bus.image import AXES

_POSITIVE = (1e-9, 1e9)
_TIMEOUT = (0.005, 0.1)
_RULES = (
    "inputs", "samples", "drive_fault", "emergency_stop", "heartbeat", "speed", "torque", "fz",
    "road_end", "steering", "plank_stopped", "plank_stands", "plank_reverses", "reference",
    "reference_gone", "wheel_stopped", "following_error",
)  # fmt: skip
RULE_CODES = {name: code for code, name in enumerate(_RULES, 1)}
"""safety rule (of `safety`) -> stop reason; bags have the numbers, so a new rule comes last"""


@dataclass(frozen=True)
class DriveParameters(Params):
    """Axis, gear, limits and safety rules."""

    axis: str = param("wheel", "place of the drive on the bus", choices=AXES, read_only=True)
    counts_per_turn: int = param(2**23, "motor encoder", unit="counts/turn", bounds=(1, 2**31))
    gear_ratio: float = param(GEAR_RATIO, "motor to output, 30.32 * 47", bounds=(1e-3, 1e6))
    output_per_turn: float = param(
        2.0 * math.pi,
        "rad of one output turn, or m for a linear axis",
        unit="unit",
        bounds=_POSITIVE,
    )
    unit: str = param("rad", "unit of the output", choices=("rad", "m"))
    direction: int = param(1, "1 or -1: sense of the motor against the output", bounds=(-1, 1))

    speed_limit: float = param(0.3, "fastest set-point", unit="unit/s", bounds=_POSITIVE)
    speed_trip: float = param(0.4, "measured speed that trips", unit="unit/s", bounds=_POSITIVE)
    torque_limit: float = param(
        12.0, "largest set-point at the motor", unit="N m", bounds=_POSITIVE, placeholder=True
    )
    torque_trip: float = param(
        15.0, "measured torque that trips", unit="N m", bounds=_POSITIVE, placeholder=True
    )
    travel_min: float = param(
        -100.0, "lowest position that a move may go to", unit="unit", bounds=(-1e6, 1e6)
    )
    travel_max: float = param(
        100.0, "highest position that a move may go to", unit="unit", bounds=(-1e6, 1e6)
    )
    move_speed: float = param(0.15, "speed of a move", unit="unit/s", bounds=_POSITIVE)
    acceleration: float = param(
        0.5, "acceleration of moves and of velocity control", unit="unit/s^2", bounds=_POSITIVE
    )
    standstill_speed: float = param(
        0.005, "slower than this counts as standing", unit="unit/s", bounds=_POSITIVE
    )
    home_in_drive: bool = param(
        True, "homing method 37 in the drive; false: the zero is kept here and the drive not asked"
    )
    start_timeout: float = param(
        1.0,
        "the drive must answer an enable, reset or homing within",
        unit="s",
        bounds=(0.05, 10.0),
    )

    stop_timeout: float = param(
        0.25,
        "the drive must leave operation within this time when it is told to",
        unit="s",
        bounds=(0.02, 10.0),
    )

    following_time: float = param(
        0.5,
        "following error: a drive may react so late; on the machine of thesis 6.3 a step of the "
        "speed comes up to 0.45 s late",
        unit="s",
        bounds=(0.02, 10.0),
    )

    rules: tuple[str, ...] = param(
        (
            "inputs", "samples", "drive_fault", "emergency_stop", "heartbeat", "speed", "torque",
            "following_error", "fz", "road_end", "steering", "plank_stopped", "plank_stands",
            "plank_reverses", "reference",
        ),
        "safety rules in the order in which they are asked; a rule that only holds the axis hides "
        "those behind it",
    )  # fmt: skip
    reference_timeout: float = param(
        0.042,
        "oldest reference: ten cycles at 250 Hz; the wheel stands 100 ms after the last one",
        unit="s",
        bounds=_TIMEOUT,
    )
    input_timeout: float = param(
        0.042,
        "longest gap between inputs, oldest hub or encoder sample",
        unit="s",
        bounds=_TIMEOUT,
    )
    heartbeat_timeout: float = param(
        0.5,
        "oldest heartbeat of the client in charge, R2 of thesis 4.2",
        unit="s",
        bounds=(0.05, 10.0),
    )
    trip_time: float = param(
        0.05, "Fz and torque trip when they are too high for so long", unit="s", bounds=(0.0, 1.0)
    )
    fz_trip: float = param(8400.0, "vertical force that trips", unit="N", bounds=(0.0, 1e5))
    free_radius: float = param(
        0.318,
        "r_0 of the mounted tire, Table 7.2 (Toyo)",
        unit="m",
        bounds=LIMITS["free_radius"].bounds,
    )
    unloaded_clearance: float = param(
        0.002, "unloaded: loaded radius above r_0 by this", unit="m", bounds=(0.0, 0.1)
    )
    unloaded_fz: float = param(
        400.0, "unloaded: filtered |Fz| below this", unit="N", bounds=(0.0, 5000.0)
    )
    road_length: float = param(
        USABLE_ROAD, "usable travel of the plank", unit="m", bounds=(0.1, 100.0)
    )
    steering_limit_deg: float = param(
        PILLAR_DEG,
        "the motor hits the pillar beyond, chapter 3; more with the hub moved inward",
        unit="deg",
        bounds=(0.0, LIMITS["steer_deg"].high),
    )

    def check(self) -> str | None:
        for name in self.rules:
            if name not in RULE_CODES:
                return f"rules: unknown rule '{name}'{nearest_hint(name, RULE_CODES)}"
        if self.direction == 0:
            return "direction is 0, must be 1 or -1"
        if self.travel_min >= self.travel_max:
            return "travel_min is not below travel_max"
        if max(self.move_speed, self.speed_limit) > self.speed_trip:
            return "move_speed and speed_limit must not exceed speed_trip"
        if self.move_speed > self.speed_limit:
            return "move_speed is above speed_limit"
        if self.torque_limit >= self.torque_trip:
            return "torque_limit is not below torque_trip"
        return None
