# SPDX-License-Identifier: Apache-2.0
"""A trivial plant behind the emulated bus: five motors with CiA 402 states and first-order
speeds."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, BusInputs, Digital

SLOWING = 0.5
"""share of the speed that is left after a cycle of braking"""
_STEPS = {0x06: 0x21, 0x07: 0x23, 0x0F: 0x27}


class Motor:
    """One axis; target velocity is followed at once, everything else lets it run down."""

    def __init__(self) -> None:
        self.status, self.position, self.velocity, self.mode = 0x40, 0.0, 0.0, 0

    def step(self, command: AxisCommand | None, dt: float) -> AxisInputs:
        word = command.control_word if command else 0
        self._transition(word)
        self.mode = command.mode if command else 0
        if self.status == 0x27 and command:
            self.velocity = float(command.target_velocity)
        else:
            self.velocity *= SLOWING
        if abs(self.velocity) < 1.0:
            self.velocity = 0.0
        self.position += self.velocity * dt
        wrapped = (round(self.position) + 2**31) % 2**32 - 2**31
        torque = command.target_torque if command else 0
        return AxisInputs(
            self.status | 0x0210, self.mode, wrapped, round(self.velocity), torque, 0
        )

    def _transition(self, word: int) -> None:
        if not word & 0x02:
            self.status = 0x40
        elif not word & 0x04:
            self.status = 0x07 if self.status in (0x27, 0x07) and self.velocity else 0x40
        elif word & 0x0F in _STEPS:
            wanted = _STEPS[word & 0x0F]
            order = (0x40, 0x21, 0x23, 0x27)
            if self.status in order and order.index(wanted) <= order.index(self.status) + 1:
                self.status = wanted


class Operator:
    """The switches of the stub."""

    def __init__(self, plant: StubPlant) -> None:
        self._plant = plant

    def emergency_stop(self, on: bool) -> None:
        self._plant.stopped = bool(on)


class StubPlant:
    """Ramps on the analogue inputs, so that channels can be told apart."""

    def __init__(self, rate_hz: int) -> None:
        self.period_ns = 1_000_000_000 // rate_hz
        self.cycle = 0
        self.stopped = False
        self.motors = [Motor() for _ in AXES]
        self.operator = Operator(self)
        self.digital_outputs = 0

    def step(self, commands: tuple[AxisCommand, ...]) -> BusInputs:
        self.cycle += 1
        by_axis = {c.axis: c for c in commands}
        for command in commands:
            self.digital_outputs = command.digital_outputs
        axes = tuple(
            m.step(by_axis.get(i), self.period_ns * 1e-9) for i, m in enumerate(self.motors)
        )
        digital = Digital.TRIGGER * (self.digital_outputs & 1)
        if not self.stopped:
            digital |= Digital.EMERGENCY_STOP_OK
        return BusInputs(
            self.cycle,
            self.cycle * self.period_ns,
            (1.0, -2.0, 3.0, -4.0, 5.0, -6.0),
            7.5,
            self.cycle,
            round(axes[0].position / 1425.04 / 2**23 * 20000),
            -self.cycle,
            2**31 - 1,
            -5,
            int(digital),
            0,
            axes,
        )


def make(rate_hz: int, seed: int) -> StubPlant:
    """Factory for `--plant`."""
    return StubPlant(rate_hz)
