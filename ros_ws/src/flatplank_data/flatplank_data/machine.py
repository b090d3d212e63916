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
FRICTION_SPEED = (0.0, 5.0, 20.0, 60.0, 120.0, 160.0, 250.0, 450.0)
"""motor speeds of FRICTION_TORQUE [rad/s]"""
FRICTION_TORQUE = (0.84, 0.79, 0.748, 0.739, 0.748, 0.752, 0.783, 0.88)
"""friction torque of the wheel drive at the motor [N m]. The thesis shows it in figures 5.3 and
5.11 only, without numbers, and the figures cannot be read. At the 142 rad/s of free rolling it
follows from the text: the simulation of (5.15) to (5.21) settles after the measured 1.54 m with
0.75 N m (and after the 1.41 m of the first simulation with 1.13 N m, the value of figure 5.11
before its scaling in section 5.6). The shape over the speed is a placeholder; `calibrate friction`
measures it"""
