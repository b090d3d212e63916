# SPDX-License-Identifier: Apache-2.0
"""Parameters of the slip sequencer, and limits for following the travel of the road."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_data.limits import LIMITS
from flatplank_data.machine import FAST, GEAR_RATIO, USABLE_ROAD
from flatplank_data.params import Params, param
from flatplank_hw.encoders import EncoderParameters

SETUP_CONSTANTS = ("commanded_speed",)
"""parameters that a plan may change while the node runs"""
_MESH = (-1e-3, 1e-3)

RADIUS = LIMITS["effective_rolling_radius"]


@dataclass(frozen=True)
class SequencerParameters(Params):
    """Road speed for the reference, and limits of requests.

    The mesh error is the travel of the road minus that of the plank encoder, with a part once per
    turn of the pinion and one once per tooth of the rack.
    """

    commanded_speed: float = param(
        FAST,
        "road speed in the reference, mean of 26 runs, thesis 4.3",
        unit="m/s",
        bounds=(1e-4, 1.0),
    )
    use_measured_speed: bool = param(
        False,
        "road speed from the plank encoder instead; the rack's ripple goes into the reference",
    )
    speed_tolerance: float = param(
        0.2,
        "largest relative deviation of the measured speed for a valid reference",
        bounds=(0.01, 10.0),
    )
    speed_patience: float = param(
        0.5,
        "time off speed until the reference becomes invalid; a start takes 0.25 s",
        unit="s",
        bounds=(0.0, 60.0),
    )
    follow_until: float = param(
        0.25,
        "road over which the wheel's angle follows the travel and recovers a late start, before "
        "the earliest slip at 0.3 m; 0: never",
        unit="m",
        bounds=(0.0, 100.0),
    )
    follow_rate: float = param(
        8.0, "rate at which lost travel is recovered", unit="1/s", bounds=(0.0, 100.0)
    )
    mismatch_limit: float = param(
        EncoderParameters.mismatch_limit,
        "the wheel's angle is not followed while motor and wheel encoder disagree by more",
        unit="rad",
        bounds=(1e-4, 10.0),
        placeholder=True,
    )
    road_scale: float = param(
        1.0, "true travel of the road over that of the plank encoder", bounds=(0.9, 1.1)
    )
    mesh_turn_cos: float = param(0.0, "once-per-turn mesh error, cosine", unit="m", bounds=_MESH)
    mesh_turn_sin: float = param(0.0, "once-per-turn mesh error, sine", unit="m", bounds=_MESH)
    mesh_tooth_cos: float = param(0.0, "once-per-tooth mesh error, cosine", unit="m", bounds=_MESH)
    mesh_tooth_sin: float = param(0.0, "once-per-tooth mesh error, sine", unit="m", bounds=_MESH)
    pinion_pitch_radius: float = param(
        0.05, "pitch radius of the plank's pinion", unit="m", bounds=(0.001, 1.0), placeholder=True
    )
    tooth_pitch: float = param(
        0.01571, "tooth pitch of the rack", unit="m", bounds=(0.001, 0.2), placeholder=True
    )
    use_road_encoder: bool = param(
        True, "the second road encoder, where it is fitted, tells the travel instead"
    )
    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    gear_ratio: float = param(GEAR_RATIO, "motor to wheel, 30.32 * 47", bounds=(1.0, 1e6))
    slip_from_motor: bool = param(
        True, "actual slip from the motor encoder, the better signal; false: wheel encoder"
    )
    road_length: float = param(
        USABLE_ROAD, "usable travel of the plank", unit="m", bounds=(0.1, 100.0)
    )
    radius_min: float = param(
        RADIUS.low, "smallest effective rolling radius", unit="m", bounds=(0.01, 2.0)
    )
    radius_max: float = param(
        RADIUS.high, "largest effective rolling radius", unit="m", bounds=(0.01, 2.0)
    )

    def check(self) -> str | None:
        return "radius_min is not below radius_max" if self.radius_min >= self.radius_max else None


JUMP = 1e-3
"""a larger step in one cycle means a new zero of the plank position [m]"""
FASTEST = 1.5
"""largest wheel speed over road speed while the wheel recovers travel; a faster wheel would
overshoot [-]"""
