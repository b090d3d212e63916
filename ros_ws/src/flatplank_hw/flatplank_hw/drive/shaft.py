# SPDX-License-Identifier: Apache-2.0
"""Converts motor counts to units of the gear output, and back."""

from __future__ import annotations

import math

from flatplank_hw.bus.image import AxisInputs
from flatplank_hw.cia402 import TORQUE_UNIT
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.encoders.counter import counts_between, wrapped


class Shaft:
    """Motion of the gear output: position [unit] from zero, velocity [unit/s]; torque at the motor
    [N m]."""

    __slots__ = ("_counts", "_per_count", "_sign", "_zero", "known", "position", "raw", "torque",
                 "velocity")  # fmt: skip

    def __init__(self, p: DriveParameters) -> None:
        self._sign = p.direction
        self._per_count = p.direction * p.output_per_turn / (p.counts_per_turn * p.gear_ratio)
        self._counts = self._zero = self.raw = 0
        self.known = False
        """true after the first inputs"""
        self.position = self.velocity = self.torque = 0.0

    def read(self, axis: AxisInputs, counter_is_set: bool) -> None:
        """Read the inputs of the drive. While the drive sets its counter (`counter_is_set`), a
        change of the counter is no motion."""
        raw = axis.position
        if not self.known:
            self._counts = self._zero = raw
            self.known = True
        elif not counter_is_set:
            self._counts += counts_between(self.raw, raw)
        self.raw = raw
        self.position = (self._counts - self._zero) * self._per_count
        self.velocity = axis.velocity * self._per_count
        self.torque = axis.torque * TORQUE_UNIT * self._sign

    def make_zero(self) -> None:
        """Make the present position zero."""
        self._zero, self.position = self._counts, 0.0

    def raw_position(self, position: float) -> int:
        """Motor counts at a position; the present reading for NaN."""
        if math.isnan(position):
            return self.raw
        return wrapped(self.raw + round((position - self.position) / self._per_count))

    def raw_velocity(self, velocity: float) -> int:
        """Motor speed [counts/s]; 0 for NaN."""
        return round(velocity / self._per_count) if not math.isnan(velocity) else 0

    def raw_torque(self, torque: float) -> int:
        """Motor torque [0.1 mN m]; 0 for NaN."""
        return round(torque * self._sign / TORQUE_UNIT) if not math.isnan(torque) else 0
