# SPDX-License-Identifier: Apache-2.0
"""A drive on a table: CiA 402 by the book, an ideal motor behind it, and a bench that a test moves
by hand."""

from __future__ import annotations

import math
from collections import deque

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital
from flatplank_hw.cia402 import State
from flatplank_hw.drive import AxisDrive, DriveParameters
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Reference, Wrench

PERIOD = 4_000_000
ZERO = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
WORDS = {
    State.NOT_READY: 0x0000,
    State.SWITCH_ON_DISABLED: 0x0240,
    State.READY_TO_SWITCH_ON: 0x0231,
    State.SWITCHED_ON: 0x0233,
    State.OPERATION_ENABLED: 0x0237,
    State.QUICK_STOP_ACTIVE: 0x0217,
    State.FAULT_REACTION_ACTIVE: 0x021F,
    State.FAULT: 0x0218,
}


class Rig:
    """`run(cycles)` lets drive core and motor answer each other; attributes are what the test
    sets."""

    delay = 2

    def __init__(self, start_counts: int = 123_456_789, **parameters) -> None:
        p = DriveParameters(**parameters)
        self.drive = AxisDrive(p)
        self.scale = p.counts_per_turn * p.gear_ratio / p.output_per_turn
        self.state = State.SWITCH_ON_DISABLED
        self.counts = float(start_counts)
        self.velocity = self.torque = 0.0
        self.mode = 0
        self.home_bit = 0
        self.deaf = self.dead_motor = False
        self.error = 0
        self.n = 0
        self.word = 0
        self.moving, self.plank_velocity, self.plank_position = False, 0.0, 0.5
        self.radius, self.fz, self.steer = 0.325, 0.0, 0.0
        self.digital, self.health = int(Digital.EMERGENCY_STOP_OK), 0
        self.reference: float | None = None
        self.source = "slip"
        self.hub_alive = self.encoders_alive = True
        self._hub = self._encoders = None
        self._pipe: deque[AxisCommand] = deque()
        self.commands: list[AxisCommand] = []
        self.samples: list[DriveSample] = []
        self.beat = ""

    def plank(self, moving: bool) -> None:
        """Start or stop the plank."""
        self.moving, self.plank_velocity = moving, 0.03092 if moving else 0.0

    def load(self, fz: float = 3700.0) -> None:
        """Put the tire on the road."""
        self.fz, self.radius = fz, 0.30

    def fault(self, code: int = 0x7500) -> None:
        """A fault of the drive."""
        self.state, self.error, self.velocity = State.FAULT, code, 0.0

    def run(self, cycles: int, until=None) -> DriveSample:
        """Some cycles, or until a condition on the sample holds (and then at most so many)."""
        for _ in range(cycles):
            sample = self.cycle()
            if until is not None and until(sample):
                return sample
        assert until is None, "the rig waited in vain"
        return sample

    def cycle(self) -> DriveSample:
        """One cycle."""
        n, stamp = self.n, self.n * PERIOD
        inputs = self.image(n, stamp)
        if self.encoders_alive:
            self._encoders = EncoderSample(
                n, stamp, self.plank_position, self.plank_velocity, 0.0, 0.0, self.steer, 0.0,
                math.nan, 0.0, 0.0, self.moving, False, 0.0,
            )  # fmt: skip
        if self.hub_alive:
            self._hub = HubSample(n, stamp, ZERO, ZERO, self.radius, 0.0, self.fz, False, 0)
        reference = None
        if self.reference is not None:
            reference = Reference(n, stamp, self.source, self.reference, True)
        if self.beat:
            self.drive.heartbeat(self.beat)
        command, sample = self.drive.step(inputs, self._encoders, self._hub, reference)
        self.commands.append(command)
        self.samples.append(sample)
        self._pipe.append(command)
        if len(self._pipe) >= self.delay:
            self.obey(self._pipe.popleft())
        self.plank_position += self.plank_velocity * PERIOD * 1e-9
        self.n += 1
        return sample

    def image(self, n: int, stamp: int) -> BusInputs:
        raw = (math.floor(self.counts) + 2**31) % 2**32 - 2**31
        word = WORDS[self.state] | self.home_bit
        torque = round(self.torque * 1e4)
        axis = AxisInputs(
            word, self.mode, raw, round(self.velocity * self.scale), torque, self.error
        )
        axes = [AxisInputs(0x0240, 0, 0, 0, 0, 0)] * len(AXES)
        axes[self.drive.index] = axis
        return BusInputs(
            n, stamp, (0.0,) * 6, 0.0, 0, 0, 0, 0, 0, self.digital, self.health, tuple(axes)
        )

    def obey(self, c: AxisCommand) -> None:
        """The drive: one transition per cycle, then its set-point until the next one."""
        before, self.word = self.word, c.control_word
        if self.deaf:
            return
        self.state = self.transition(c.control_word, before)
        dt = PERIOD * 1e-9
        enabled = self.state is State.OPERATION_ENABLED
        if not enabled or self.dead_motor:
            self.velocity = self.torque = 0.0
            return
        if c.mode != self.mode:
            self.home_bit = 0
        self.mode = c.mode
        if c.mode == 9:
            self.velocity = c.target_velocity / self.scale
        elif c.mode == 10:
            self.torque = c.target_torque * 1e-4
            self.velocity = 0.02 * self.torque
        elif c.mode == 8:
            gap = (c.target_position - math.floor(self.counts) + 2**31) % 2**32 - 2**31
            self.velocity = gap / self.scale / dt
        elif c.mode == 6:
            self.velocity = 0.0
            if c.control_word & 0x10:
                self.counts, self.home_bit = 0.0, 0x1000
        self.counts += self.velocity * self.scale * dt

    def transition(self, word: int, before: int) -> State:
        s = self.state
        if s is State.FAULT:
            reset = word & 0x80 and not before & 0x80
            self.error = 0 if reset else self.error
            return State.SWITCH_ON_DISABLED if reset else s
        if not word & 0x02:
            return State.SWITCH_ON_DISABLED
        if not word & 0x04:
            stops = s in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE)
            return State.QUICK_STOP_ACTIVE if stops else State.SWITCH_ON_DISABLED
        if word & 0x0F == 0x06:
            return State.READY_TO_SWITCH_ON
        if word & 0x0F == 0x07 and s is not State.SWITCH_ON_DISABLED:
            return State.SWITCHED_ON
        if word & 0x0F == 0x0F and s in (State.SWITCHED_ON, State.OPERATION_ENABLED):
            return State.OPERATION_ENABLED
        return s


def up(mode: str = "position", value: float = 0.0, **parameters) -> Rig:
    """A rig that is enabled in a mode; the tire hangs free and the plank stands."""
    rig = Rig(**parameters)
    rig.run(2)
    assert rig.drive.set_operation_mode(mode, value).accepted
    assert rig.drive.enable().accepted
    rig.run(20, until=lambda s: s.state == State.OPERATION_ENABLED)
    return rig
