# SPDX-License-Identifier: Apache-2.0
"""Registry of all troubles of the bench; log, /diagnostics, messages and the page
docs/reference/troubles.md use its texts."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from flatplank_hw.bus.image import Health


class Level(IntEnum):
    """Severity as in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Trouble:
    """One entry of the registry; each text is a clause without a full stop."""

    name: str
    level: Level
    text: str
    """what the operator observes"""
    cause: str
    """what it means"""
    remedy: str
    """what to do"""

    def line(self, detail: str = "") -> str:
        """Text for the log and /diagnostics."""
        seen = f"{self.text} ({detail})" if detail else self.text
        return f"{seen}; {self.remedy}" if self.remedy else seen


def table_of_troubles(*troubles: Trouble) -> dict[str, Trouble]:
    """Troubles by name; ValueError for a duplicate name."""
    by_name = {trouble.name: trouble for trouble in troubles}
    if len(by_name) < len(troubles):
        raise ValueError("two troubles of one name")
    return by_name


_ERROR, _WARN, _OK = Level.ERROR, Level.WARN, Level.OK
AGAIN = "then enable the drive again"


DRIVE = table_of_troubles(
    Trouble(
        "inputs", _ERROR, "inputs of the bus are stale or lost",
        "no fresh image of the bus reached the drive node in time, or the bus says that it is bad",
        f"look at the trouble of the bus, {AGAIN}",
    ),
    Trouble(
        "samples", _ERROR, "no samples arrive from hub or encoders",
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
        "heartbeat", _ERROR, "no heartbeats arrive from the client in charge",
        "the client that claimed the bench has not been heard for 0.5 s: it hangs, was closed, or "
        "its network is gone",
        f"start the client again or release the claim (/operator/claim with no name), {AGAIN}",
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
        "filtered |Fz| above fz_trip, or no number, for longer than trip_time",
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
        "slip_sequencer or free_rolling_controller has ended, hangs, has no valid set-point, or "
        "its set-point is not finite or beyond speed_limit or torque_limit",
        f"see that the source of this mode runs and has a set-point within the limits, {AGAIN}",
    ),
    Trouble(
        "reference_gone", _ERROR, "no good references arrive from the axis's controller",
        "load_controller, steering_hold or camber_hold has ended, hangs, or its set-point is not "
        "finite or beyond speed_limit",
        f"see that the controller of this axis runs, {AGAIN}",
    ),
    Trouble(
        "wheel_stopped", _ERROR, "the wheel was stopped under a loaded tire: the plank stops too",
        "the wheel's drive left operation while this drive moved the plank, which would drag the "
        "tire",
        "see why the wheel stopped, unload the tire, then enable both drives again",
    ),
    Trouble(
        "following_error", _ERROR, "the drive does not follow its commands",
        "the motor is further from its commands than (standstill_speed + v) following_time + "
        "v^2 / (2 acceleration) allows, v the largest change of speed since it obeyed last, "
        "commanded or missing, in position control the largest speed; in torque control: the "
        "torque is off by more than torque_trip - torque_limit for longer than following_time; in "
        "free rolling: the same error from the range in which a tire rolls, standing to kappa 0.5",
        "look for what blocks the axis, and at mode and display of the drive; for free rolling "
        f"enable it before the plank moves, {AGAIN}",
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
        "does_not_stop", _ERROR, "the drive does not stop: no command is sent to it any more",
        "it stayed in operation for stop_timeout although it was told to stop; without new "
        "commands the guard of the bus and the drive's watchdog stop it",
        "press the emergency stop, then look at the drive",
    ),
    Trouble(
        "drag", _ERROR, "the wheel stands and the plank drags the tire over the road",
        "the wheel's drive is out of operation while the plank goes on under a loaded tire",
        "turn the plank's switch to stop (simulated: /simulated_plant/plank with direction 0), "
        "then unload",
    ),
)  # fmt: skip

BUS = table_of_troubles(
    Trouble(
        "bus_degraded", _WARN, "single frames of the bus were lost",
        "one or two cycles in a row without a good answer; they are bridged",
        "look at cable, connectors and the load of the computer when it comes often",
    ),
    Trouble(
        "bus_stale", _ERROR, "the answers of the bus belong to an older cycle",
        "frames are held up on their way, by a switch or another program on the interface",
        "use an interface of its own without a switch, close other masters",
    ),
    Trouble(
        "bus_lost", _ERROR, "the bus does not answer",
        "more than two cycles in a row without an answer of all slaves",
        "look at power, cable and the named slave; the bus comes back by itself, then reset_fault "
        "and enable the drives",
    ),
    Trouble(
        "slave_fault", _ERROR, "a slave of the bus is not in operation",
        "the named slave has left OP; its AL code says why",
        "look at the slave; the bus brings it back by itself, then reset_fault and enable the "
        "drives",
    ),
    Trouble(
        "bus_recovery", _WARN, "the bus is being brought back",
        "the master acknowledges, configures or scans again after a loss",
        "wait; when it goes on and on, look at the slave that is named",
    ),
    Trouble(
        "bus_emergency", _WARN, "a slave sent an emergency message",
        "the slave reports a trouble of its own by its mailbox",
        "look the code up in the manual of the slave",
    ),
    Trouble(
        "bus_ended", _ERROR, "the bus process has ended, all axes are stopped",
        "it was killed or has crashed; the slaves' watchdogs have stopped the axes",
        "start the bench again",
    ),
    Trouble(
        "too_slow", _WARN, "the computer is too slow for real time",
        "the simulated bus dropped cycles that it could not make in time",
        "end other programs, or use pace lockstep, a lower rate or batches",
    ),
    Trouble(
        "second_commander", _ERROR, "another node commands an axis of this bench",
        "a second drive node, or a program that publishes on /bus/outputs; where the bench cannot "
        "tell which of the two is its own, it passes on no command, and the drive stops",
        "end the node that does not belong to this bench, or give it a namespace of its own",
    ),
    Trouble(
        "drives_silent", _ERROR, "no commands come from a drive node",
        "the simulated bus went on without the answer of an axis: its node has ended",
        "see that the drive nodes run; start the bench again",
    ),
    Trouble(
        "bus_waits", _WARN, "the simulated bus waits for a drive node",
        "the node is there and has not answered the last cycle, so bench time stands: the "
        "computer is busy, the node was stopped, or a node that it needs was not started",
        "end other programs; see that all nodes of the bench run",
    ),
)  # fmt: skip

OF_HEALTH = {
    Health.DEGRADED: "bus_degraded",
    Health.STALE: "bus_stale",
    Health.LOST: "bus_lost",
    Health.SLAVE_FAULT: "slave_fault",
}
"""health of an image -> trouble"""

MEASURING = table_of_troubles(
    Trouble(
        "saturated", _WARN, "inputs of the hub are at their limit",
        "the amplifier of a channel is beyond saturation_volts: the forces made of it are wrong; "
        "what is not finite or beyond 100 V counts as no number: neither filter nor tare take it, "
        "and the drives stop by `fz` or `plank_stands`",
        "unload, look at cable and amplifier of the channel, make the run again",
    ),
    Trouble(
        "not_calibrated", _WARN, "the constants of this node are not calibrated",
        "the node was started by hand, or the machine has no calibration book: it measures with "
        "the constants of its package",
        "start the bench by `ros2 launch` or `flatplank bench`, with a book; `flatplank "
        "calibrate` makes one",
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

NODES = table_of_troubles(
    Trouble(
        "refused", _WARN, "a call was refused",
        "what was asked for is not possible now or its values are wrong; nothing has changed",
        "",
    ),
    Trouble(
        "unconnected", _WARN, "a topic has no publisher or subscriber",
        "the other node was not started, or has ended",
        "start it; `ros2 node list` says which nodes run",
    ),
    Trouble(
        "node_silent", _ERROR, "a node is not heard any more",
        "it has ended, was killed, or hangs",
        "look for its last lines in the terminal, then start the bench again",
    ),
    Trouble(
        "node_ended", _ERROR, "a node that the bench needs has ended",
        "it was killed or has given up; every node of a bench is needed, so the others end too",
        "read why in the lines before, then start the bench again",
    ),
)  # fmt: skip

SECTIONS = {
    "The drives": DRIVE,
    "The bus": BUS,
    "Measuring and recording": MEASURING,
    "Nodes and calls": NODES,
}
"""section title of docs/reference/troubles.md -> troubles"""

TROUBLES = table_of_troubles(
    *(trouble for section in SECTIONS.values() for trouble in section.values())
)
