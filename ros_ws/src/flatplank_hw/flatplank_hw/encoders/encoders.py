# SPDX-License-Identifier: Apache-2.0
"""The encoders of the bench: counts to positions, velocities and the state of motion."""

from __future__ import annotations

import math

from flatplank_data.params import require_changes_only
from flatplank_hw.answers import ActionQueue, Answer
from flatplank_hw.bus.image import BusInputs, Digital
from flatplank_hw.cia402 import CiaMode
from flatplank_hw.encoders.counter import SlopeCounter
from flatplank_hw.encoders.params import SETUP_CONSTANTS, EncoderParameters
from flatplank_hw.samples import EncoderSample

_TURN = 2.0 * math.pi
_TRIGGER = int(Digital.TRIGGER)
_MAX_GAP = 50
_RATE_TOLERANCE = 0.02


class Encoders:
    """Plank, wheel, steering, road camber, second road encoder and the wheel drive's motor (axis
    0)."""

    def __init__(self, p: EncoderParameters) -> None:
        self.parameters = p
        self._agenda = ActionQueue()

        def samples(window: float) -> int:
            return max(round(window * p.rate_hz), 2)

        self._window = samples(p.moving_window)
        self._plank = SlopeCounter(max(samples(p.plank_velocity_window), self._window + 1))
        self._wheel = SlopeCounter(samples(p.wheel_velocity_window))
        self._motor = SlopeCounter(samples(p.motor_velocity_window))
        self._road = SlopeCounter(samples(p.plank_velocity_window))
        self._per_plank = _TURN * p.pinion_pitch_radius / p.plank_counts_per_turn
        self._per_wheel = _TURN / p.wheel_counts_per_turn
        self._per_motor = _TURN / p.motor_counts_per_turn
        self._per_steer = _TURN / p.steer_counts_per_turn
        self._per_camber = _TURN / p.camber_counts_per_turn
        self._per_road = _TURN * p.road_encoder_radius / p.road_counts_per_turn
        self._steer_offset = math.radians(p.slip_angle_offset_deg)
        self._rate = p.rate_hz
        self._plank_zero = self._road_zero = 0
        self._mismatch_zero: float | None = None
        self._armed, self._level, self._moving = True, True, False
        self._last: BusInputs | None = None

    @property
    def armed(self) -> bool:
        """True when the next motion trigger sets the plank position to zero."""
        return self._armed

    def set_constants(self, p: EncoderParameters) -> None:
        """Change set-up constants from the next cycle on; ValueError for any other change."""
        require_changes_only(self.parameters, p, SETUP_CONSTANTS, "encoders")
        self.parameters = p
        self._steer_offset = math.radians(p.slip_angle_offset_deg)

    def arm(self) -> Answer:
        """Let the next motion trigger set the plank position to zero."""
        return self._agenda.accept(
            lambda: setattr(self, "_armed", True),
            "the next motion trigger makes the plank position 0 m",
        )

    def step(self, inputs: BusInputs) -> EncoderSample:
        """Return the sample of one bus cycle; takes about 5 us."""
        cycle = inputs.cycle
        agenda = self._agenda
        if agenda.due:
            agenda.run()
        agenda.last_cycle = cycle
        plank, wheel, motor = self._plank, self._wheel, self._motor
        motor_axis = inputs.axes[0]
        # homing resets the counter of the drive: that is no motion
        if motor_axis.mode_display == CiaMode.HOMING:
            motor.rezero(motor_axis.position)
        last = self._last
        if last is not None and (cycle - last.cycle != 1 or inputs.stamp_ns <= last.stamp_ns):
            self._bridge(cycle - last.cycle, inputs)
        elif last is not None:
            self._check_rate(inputs.stamp_ns - last.stamp_ns)
        self._last = inputs
        plank.update(inputs.plank_counts)
        wheel.update(inputs.wheel_counts)
        motor.update(motor_axis.position)
        moving = self._watch_plank(plank)
        trigger = bool(inputs.digital & _TRIGGER)
        fitted = self.parameters.road_encoder_fitted
        if fitted:
            self._road.update(inputs.road_counts)
        if trigger != self._level:
            self._on_trigger(trigger)

        rate = self._rate
        wheel_angle = wheel.counts * self._per_wheel
        motor_angle = motor.counts * self._per_motor
        mismatch = motor_angle / self.parameters.gear_ratio - wheel_angle
        if self._mismatch_zero is None:
            self._mismatch_zero = mismatch
        return EncoderSample(
            cycle,
            inputs.stamp_ns,
            (plank.counts - self._plank_zero) * self._per_plank,
            plank.slope * rate * self._per_plank,
            wheel_angle,
            wheel.slope * rate * self._per_wheel,
            inputs.steer_counts * self._per_steer + self._steer_offset,
            inputs.camber_counts * self._per_camber,
            (self._road.counts - self._road_zero) * self._per_road if fitted else math.nan,
            motor_angle,
            motor.slope * rate * self._per_motor,
            moving,
            trigger,
            mismatch - self._mismatch_zero,
        )

    def _watch_plank(self, plank: SlopeCounter) -> bool:
        moved = abs(plank.counts - plank.back(self._window))
        p = self.parameters
        limit = p.moving_stop_counts if self._moving else p.moving_start_counts
        self._moving = moved >= limit
        return self._moving

    def _on_trigger(self, level: bool) -> None:
        """Set the plank position to zero at a rising edge when armed, unless the plank moves
        backward."""
        backwards = self._plank.counts < self._plank.back(self._window) - 1
        if self._per_plank < 0.0:
            backwards = self._plank.counts > self._plank.back(self._window) + 1
        if level and self._armed and not backwards:
            self._plank_zero, self._road_zero = self._plank.counts, self._road.counts
            self._armed = False
        self._level = level

    def _check_rate(self, period_ns: int) -> None:
        # follow the period of the bus, ignore its jitter
        if abs(period_ns * self._rate * 1e-9 - 1.0) > _RATE_TOLERANCE and period_ns > 0:
            self._rate = 1e9 / period_ns

    def _bridge(self, gap: int, now: BusInputs) -> None:
        """Interpolate the readings of lost cycles linearly, so that velocities stay correct."""
        if not 1 < gap <= _MAX_GAP:
            for counter in (self._plank, self._wheel, self._motor):
                counter.refill(counter.counts)
            return
        self._plank.bridge(now.plank_counts, gap)
        self._wheel.bridge(now.wheel_counts, gap)
        self._motor.bridge(now.axes[0].position, gap)
        if self.parameters.road_encoder_fitted:
            self._road.bridge(now.road_counts, gap)
