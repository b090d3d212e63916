# SPDX-License-Identifier: Apache-2.0
"""Parameters of the encoders: counts, gears and offsets of the machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_data.machine import COUNTS_PER_TURN, GEAR_RATIO
from flatplank_data.params import Params, param

_WINDOW = (0.001, 5.0)
SETUP_CONSTANTS = ("slip_angle_offset_deg",)
"""parameters that the operator may change while the bench runs"""


def counts_param(note: str, default: int = COUNTS_PER_TURN, placeholder: bool = False) -> Any:
    """Declare a parameter for counts per turn; a negative value reverses the sign."""
    bounds = (-(2**31), 2**31)
    return param(default, note, unit="counts/turn", bounds=bounds, placeholder=placeholder)


@dataclass(frozen=True)
class EncoderParameters(Params):
    """Parameters of the encoders; negative counts per turn reverse the sign."""

    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    plank_counts_per_turn: int = counts_param("pinion encoder, chapter 3")
    pinion_pitch_radius: float = param(
        0.05,
        "pitch radius of the plank drive's pinion",
        unit="m",
        bounds=(0.001, 1.0),
        placeholder=True,
    )
    wheel_counts_per_turn: int = counts_param("wheel encoder, chapter 3")
    motor_counts_per_turn: int = counts_param("wheel drive motor, 23 bit", 2**23)
    gear_ratio: float = param(GEAR_RATIO, "motor to wheel, 30.32 * 47", bounds=(1.0, 1e6))
    steer_counts_per_turn: int = counts_param(
        "steering encoder, counts per turn of the turntable", placeholder=True
    )
    slip_angle_offset_deg: float = param(
        0.0, "added to the measured steering angle", unit="deg", bounds=(-90.0, 90.0)
    )
    camber_counts_per_turn: int = counts_param("road camber encoder", placeholder=True)
    road_encoder_fitted: bool = param(False, "a second encoder rolls on the road itself")
    road_counts_per_turn: int = counts_param("second road encoder", placeholder=True)
    road_encoder_radius: float = param(
        0.05,
        "radius of the second road encoder's measuring wheel",
        unit="m",
        bounds=(0.001, 1.0),
        placeholder=True,
    )

    plank_velocity_window: float = param(
        0.1, "span of the line fit for the plank velocity", unit="s", bounds=_WINDOW
    )
    wheel_velocity_window: float = param(
        0.1, "span of the line fit for the wheel velocity", unit="s", bounds=_WINDOW
    )
    motor_velocity_window: float = param(
        0.02, "span of the line fit for the motor velocity", unit="s", bounds=_WINDOW
    )

    moving_window: float = param(
        0.04, "the plank moves or rests by its counts over so long", unit="s", bounds=(0.005, 0.09)
    )
    moving_start_counts: int = param(
        3, "moves from so many counts over the window on", unit="counts", bounds=(1, 10000)
    )
    moving_stop_counts: int = param(
        2, "rests again below so many counts over the window", unit="counts", bounds=(1, 10000)
    )

    mismatch_limit: float = param(
        0.02,
        "motor and wheel encoder must agree so far on the wheel's angle",
        unit="rad",
        bounds=(1e-4, 10.0),
        placeholder=True,
    )

    def check(self) -> str | None:
        for name in ("plank", "wheel", "motor", "steer", "camber", "road"):
            if getattr(self, f"{name}_counts_per_turn") == 0:
                return f"{name}_counts_per_turn is 0: give the counts of one turn"
        if self.moving_stop_counts > self.moving_start_counts:
            return "moving_stop_counts is above moving_start_counts: the plank could never rest"
        return None
