# SPDX-License-Identifier: Apache-2.0
"""Names by which a bus file says what an entry of the process data is to the bench."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, Digital

VOLTS = ("C1", "C2", "C3", "C4", "C5", "C6", "lvdt")
"""analogue inputs [V]: the six bridges and the axle height"""

COUNTS = ("plank_counts", "wheel_counts", "steer_counts", "camber_counts", "road_counts")
"""encoder terminals [counts]; narrower counters than 32 bits are continued by the master"""

DIGITAL = {
    "trigger": Digital.TRIGGER,
    "emergency_stop_ok": Digital.EMERGENCY_STOP_OK,
    "limit_front": Digital.LIMIT_FRONT,
    "limit_rear": Digital.LIMIT_REAR,
}

AXIS_INPUTS = ("status_word", "mode_display", "position", "velocity", "torque", "error_code")
AXIS_OUTPUTS = ("control_word", "mode", "target_position", "target_velocity", "target_torque")
TORQUES = ("torque", "target_torque")

DIGITAL_OUTPUTS = "digital_outputs"
ECHO = "echo"
"""a padding byte of the outputs that no slave reads: the master counts cycles in it"""

INPUTS = frozenset([*VOLTS, *COUNTS, *DIGITAL, *(f"{a}.{w}" for a in AXES for w in AXIS_INPUTS)])
OUTPUTS = frozenset([DIGITAL_OUTPUTS, ECHO, *(f"{a}.{w}" for a in AXES for w in AXIS_OUTPUTS)])
