# SPDX-License-Identifier: Apache-2.0
"""The steering angle held against the play of its worm drive; profiles for steering and camber."""

from flatplank_control.steering_hold.axis import AngleControl, AngleParameters
from flatplank_control.steering_hold.hold import HoldParameters, SteeringHold
from flatplank_control.steering_hold.profiles import PROFILES, Profile

__all__ = [
    "PROFILES",
    "AngleControl",
    "AngleParameters",
    "HoldParameters",
    "Profile",
    "SteeringHold",
]
