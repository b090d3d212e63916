# SPDX-License-Identifier: Apache-2.0
"""The bus, simulated or real."""

from __future__ import annotations

from flatplank_hw.bus.image import Health
from flatplank_hw.troubles.trouble import Level, Trouble, table

_ERROR, _WARN = Level.ERROR, Level.WARN

BUS = table(
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
        "drives_silent", _ERROR, "no commands come from a drive node",
        "the simulated bus went on without the answer of an axis: its node has ended or hangs",
        "see that the drive nodes run; start the bench again",
    ),
)  # fmt: skip

OF_HEALTH = {
    Health.DEGRADED: "bus_degraded",
    Health.STALE: "bus_stale",
    Health.LOST: "bus_lost",
    Health.SLAVE_FAULT: "slave_fault",
}
"""health of an image -> trouble"""
