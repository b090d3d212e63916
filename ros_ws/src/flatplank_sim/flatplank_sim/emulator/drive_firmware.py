# SPDX-License-Identifier: Apache-2.0
"""Firmware of a servo drive between process data and motor: communication faults, injected faults,
stops.

The plant simulates the motor, its CiA 402 states and modes. The firmware passes the commands on,
or brakes instead.
"""

from __future__ import annotations

from flatplank_hw.bus.image import AxisCommand, AxisInputs
from flatplank_hw.cia402 import (
    DISABLE_VOLTAGE,
    ENERGISED,
    FAULT_RESET,
    FAULT_STATUS,
    QUICK_STOP,
    STATE_BITS,
    decode,
)
from flatplank_sim.emulator.slave import EmulatedSlave

COMMUNICATION = 0x7500
FOLLOWING_ERROR = 0x8611
STOP_NS = 200_000_000
"""braking time of a faulted drive before it cuts the power [ns]"""
STUCK_NS = 60_000_000
"""an axis that stands still for this time in spite of a command has a following error [ns]"""

DriveWords = tuple[int, int, int, int, int]
"""control word, mode, target position, velocity, torque, as on the bus"""
IDLE: DriveWords = (0, 0, 0, 0, 0)


class DriveFirmware:
    """One drive. A fault stays until a rising edge of the reset bit after its cause is gone."""

    def __init__(self, axis: int, slave: EmulatedSlave) -> None:
        self.axis = axis
        self.slave = slave
        self.fault = 0
        self.cause_persists = False
        self.stuck = False
        self.safe_stop = False
        """true when the emergency stop circuit is open"""
        self._energised = False
        self._reset_bit = True
        self._braking_since: int | None = None
        self._stuck_since: int | None = None
        slave.reset_hooks.append(self.power_on)

    def power_on(self) -> None:
        """Reset as at power-on; only a cause that persists is kept."""
        self.fault = self.fault if self.cause_persists else 0
        self._braking_since = None

    def trip(self, code: int, persists: bool = False) -> None:
        """Go to the fault state and send an emergency message."""
        self.cause_persists = persists
        if not self.fault:
            self.fault = code
            self._braking_since = None
            if self.slave.mailbox is not None:
                self.slave.mailbox.emergency(code, 0x01)

    def command(self, asked: DriveWords, cycle: int, now: int) -> AxisCommand:
        """Command to the motor for what the bus has `asked`."""
        if not self.slave.operational:
            if self._energised and not self.fault:
                self.trip(COMMUNICATION)
            asked = IDLE
        word = asked[0]
        reset = bool(word & FAULT_RESET)
        if reset and not self._reset_bit and self.fault and not self.cause_persists:
            self._clear()
        self._reset_bit = reset
        if self.fault or self.safe_stop or self.stuck:
            word = self._brake(now)
        else:
            self._braking_since = None
        return AxisCommand(self.axis, cycle, word, *asked[1:], 0)

    def report(self, motor: AxisInputs, asked: DriveWords, now: int) -> AxisInputs:
        """Inputs that the drive reports about its motor."""
        self._energised = decode(motor.status_word) in ENERGISED
        if self.stuck and not self.fault:
            self._watch_following(asked, now)
            if not self.fault:
                return motor._replace(status_word=motor.status_word & ~STATE_BITS | 0x0037)
        if self.fault:
            return motor._replace(status_word=FAULT_STATUS, error_code=self.fault)
        return motor

    def _brake(self, now: int) -> int:
        if self._braking_since is None:
            self._braking_since = now
        return QUICK_STOP if now - self._braking_since < STOP_NS else DISABLE_VOLTAGE

    def _clear(self) -> None:
        self.fault = 0
        self._stuck_since = None
        if self.slave.mailbox is not None:
            self.slave.mailbox.emergency(0, 0)

    def _watch_following(self, asked: DriveWords, now: int) -> None:
        commanded = asked[0] & 0x0F == 0x0F and any(asked[3:])
        if not commanded:
            self._stuck_since = None
        elif self._stuck_since is None:
            self._stuck_since = now
        elif now - self._stuck_since > STUCK_NS:
            self.trip(FOLLOWING_ERROR)
