# SPDX-License-Identifier: Apache-2.0
"""Constants of the machine: the defaults of every parameter that needs one, each with its source.

A parameter file of a node may say another value.
"""

from __future__ import annotations

GEAR_RATIO = 1425.04
"""motor to wheel: 30.32 * 47, thesis chapter 3 [-]"""
COUNTS_PER_TURN = 20000
"""of the encoders on wheel, pinion, turntable and camber axis, thesis chapter 3"""
ROAD_LENGTH = 4.22
"""of the plank, thesis section 3.1 [m]"""
USABLE_ROAD = 4.2
"""travel after which the tire comes to the end of the road [m]"""
USUAL_RADIUS = 0.3108
"""effective rolling radius of the thesis's tire, the first value where one has to be given [m]"""
FAST = 0.03092
"""fast speed of the plank, thesis 4.3 [m/s]"""
SLOW = 0.0015
"""the other one [m/s]"""
