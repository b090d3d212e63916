# SPDX-License-Identifier: Apache-2.0
"""Stops and holds of a drive; the names of the safety rules are theirs here."""

from __future__ import annotations

from flatplank_hw.troubles.trouble import Level, Trouble, table

AGAIN = "then enable the drive again"
_ERROR, _WARN, _OK = Level.ERROR, Level.WARN, Level.OK

DRIVE = table(
    Trouble(
        "inputs", _ERROR, "inputs of the bus are stale or lost",
        "no fresh image of the bus reached the drive node in time, or the bus says that it is bad",
        f"look at the trouble of the bus, {AGAIN}",
    ),
    Trouble(
        "samples", _ERROR, "hub or encoders have fallen silent",
        "measurement_hub or encoders has ended, hangs, or the computer is too slow",
        f"see that both nodes run and that the computer keeps up, {AGAIN}",
    ),
    Trouble(
        "drive_fault", _ERROR, "the drive reports a fault",
        "the drive, or the guard in front of the bus, has stopped the axis; the error code says "
        "why",
        f"mend the cause, call reset_fault, {AGAIN}",
    ),
    Trouble(
        "emergency_stop", _ERROR, "the emergency stop is pressed",
        "the emergency stop circuit is open",
        f"release the button when the bench is safe, {AGAIN}",
    ),
    Trouble(
        "heartbeat", _ERROR, "the operator in charge has fallen silent",
        "the client that claimed the bench has not been heard for 0.5 s: it hangs, was closed, or "
        "its network is gone",
        f"start the client again or give the charge back (/operator/claim with no name), {AGAIN}",
    ),
    Trouble(
        "speed", _ERROR, "the axis is faster than its limit",
        "measured speed above speed_trip",
        f"look for what drives the axis, {AGAIN}",
    ),
    Trouble(
        "torque", _ERROR, "the torque is above its limit",
        "measured torque above torque_trip for longer than trip_time",
        f"look for what blocks the axis, or ask for less slip or load, {AGAIN}",
    ),
    Trouble(
        "fz", _ERROR, "the vertical force is above its limit",
        "filtered Fz above fz_trip for longer than trip_time",
        f"lift the axle, {AGAIN}",
    ),
    Trouble(
        "road_end", _ERROR, "the plank is at the end of the road",
        "the plank went beyond road_length under a loaded tire",
        f"stop the plank, unload, drive it back, {AGAIN}",
    ),
    Trouble(
        "steering", _ERROR, "steered so far that the motor hits the pillar",
        "steering angle beyond steering_limit_deg",
        f"steer back, {AGAIN}",
    ),
    Trouble(
        "plank_stopped", _ERROR, "the plank stopped under the tire",
        "the wheel was turning on a loaded tire and the road came to rest",
        f"see why the plank stopped, {AGAIN} before the plank moves",
    ),
    Trouble(
        "plank_stands", _OK, "the plank stands under the tire: waiting",
        "the wheel is enabled and begins to turn with the plank",
        "",
    ),
    Trouble(
        "plank_reverses", _OK, "the plank moves back: waiting",
        "slip and free rolling are for a plank that moves forward",
        "unload the tire before the plank goes back",
    ),
    Trouble(
        "reference", _ERROR, "the reference is too old or not valid",
        "slip_sequencer or free_rolling_controller has ended, hangs, or has no valid set-point",
        f"see that the source of this mode runs and has a set-point, {AGAIN}",
    ),
    Trouble(
        "reference_gone", _ERROR, "the axis's controller has fallen silent",
        "load_controller, steering_hold or camber_hold has ended or hangs",
        f"see that the controller of this axis runs, {AGAIN}",
    ),
    Trouble(
        "wheel_stopped", _ERROR, "the wheel was stopped under a loaded tire: the plank stops too",
        "the wheel's drive left operation while this drive moved the plank, which would drag the "
        "tire",
        "see why the wheel stopped, unload the tire, then enable both drives again",
    ),
    Trouble(
        "quick_stop", _WARN, "quick stop was asked for",
        "somebody called quick_stop, or pressed STOP on the panel",
        "enable the drive when the bench is safe",
    ),
    Trouble(
        "left_operation", _ERROR, "the drive left operation by itself",
        "it was switched off at the drive or by its own safety input, and reports no fault",
        f"look at the drive's display, {AGAIN}",
    ),
    Trouble(
        "no_answer", _ERROR, "the drive did not answer in time",
        "after an enable or a homing the drive did not come to the wanted state within "
        "start_timeout",
        f"see that the drive has power and its bus is in OP, {AGAIN}",
    ),
    Trouble(
        "drag", _ERROR, "the wheel stands and the plank drags the tire over the road",
        "the wheel's drive is out of operation while the plank goes on under a loaded tire",
        "turn the plank's switch to stop (simulated: /simulated_plant/plank with direction 0), "
        "then unload",
    ),
)  # fmt: skip

ERROR_CODES = {
    0x2310: "too much current",
    0x3210: "voltage of the DC link too high",
    0x3220: "voltage of the DC link too low",
    0x4210: "the drive is too hot",
    0x7121: "the motor is blocked",
    0x7305: "fault of the motor's encoder",
    0x7500: "no communication: the watchdog has tripped, or the bus is bad",
    0x8130: "the commands of the drive's node are too old",
    0x8611: "following error",
    0xFF01: "the emergency stop circuit is open",
    0xFF02: "a limit switch was run into",
}
"""603Fh (CiA 402; those of our own guard in the manufacturer's part) -> words"""


def error_words(code: int) -> str:
    """An error code of a drive for people."""
    return f"0x{code:04X}, {ERROR_CODES.get(code, 'see the manual of the drive')}"
