# SPDX-License-Identifier: Apache-2.0
"""What spoils a measurement or its record."""

from __future__ import annotations

from flatplank_hw.troubles.trouble import Level, Trouble, table

_ERROR, _WARN = Level.ERROR, Level.WARN

MEASURING = table(
    Trouble(
        "saturated", _WARN, "bridges of the hub are at their limit",
        "the amplifier of a channel is beyond saturation_volts: the forces made of it are wrong",
        "unload, look at cable and amplifier of the channel, make the run again",
    ),
    Trouble(
        "tare_given_up", _WARN, "the zero of the hub was not set anew",
        "a tare had begun, and the plank moved before it had its samples: the zero is the old one",
        "stop the plank, then tare again",
    ),
    Trouble(
        "cross_check", _WARN, "motor and wheel encoder do not agree",
        "the wheel's angle by the motor and by its own encoder differ by more than "
        "mismatch_limit: a coupling slips, counts are lost, or a gear ratio is wrong",
        "look at coupling and encoder of the wheel, check gear_ratio and counts per turn",
    ),
    Trouble(
        "cycles_lost", _WARN, "bus cycles are missing in the bag",
        "messages did not reach the recorder: the computer is too slow or the disk is",
        "make the run again with less load on the computer; models are fitted to what is there",
    ),
    Trouble(
        "recording_failed", _ERROR, "the bag could not be written on",
        "the disk is full, or was taken away",
        "make room and make the run again; what was written is kept",
    ),
    Trouble(
        "bag_mended", _WARN, "an unfinished bag was closed",
        "an earlier recorder was killed while it recorded; up to half a second is missing",
        "look at the run before it is used; its status is interrupted",
    ),
    Trouble(
        "measurement_stopped", _ERROR, "a measurement was stopped",
        "the runner could not go on; wheel and plank were stopped and the bag was closed",
        "mend what is named, then start the measurement again",
    ),
)  # fmt: skip
