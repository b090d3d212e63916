# SPDX-License-Identifier: Apache-2.0
"""Constants of the machine, each with its source; they are the defaults of node parameters.

The parameter file of a node may override them.
"""

from __future__ import annotations

GEAR_RATIO = 1425.04
"""motor to wheel: 30.32 * 47, thesis chapter 3 [-]"""
COUNTS_PER_TURN = 20000
"""encoders on wheel, pinion, turntable and camber axis [counts per turn]; thesis chapter 3"""
ROAD_LENGTH = 4.22
"""length of the plank [m]; thesis section 3.1"""
USABLE_ROAD = 4.2
"""travel at which the tire reaches the end of the road [m]"""
USUAL_RADIUS = 0.3108
"""effective rolling radius of the tire of the thesis; start value when none is known [m]"""
FAST = 0.03092
"""fast speed of the plank, thesis 4.3 [m/s]"""
SLOW = 0.0015
"""slow speed of the plank [m/s]"""
