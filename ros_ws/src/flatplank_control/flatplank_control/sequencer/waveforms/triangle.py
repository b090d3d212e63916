# SPDX-License-Identifier: Apache-2.0
"""Triangular slip over the road."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import LENGTH, MAX_SLIP, SLIP, Waveform
from flatplank_data.params import param


@dataclass(frozen=True)
class Triangle(Waveform):
    """offset + amplitude times a triangle of period `wavelength` that starts upwards from 0."""

    name = "triangle"
    amplitude: float = param(0.0, "of the slip", bounds=SLIP)
    wavelength: float = param(1.0, "of the triangle on the road", unit="m", bounds=LENGTH)
    offset: float = param(0.0, "mean slip", bounds=SLIP)

    def check(self) -> str | None:
        peak = abs(self.offset) + abs(self.amplitude)
        return f"the slip reaches {peak:g}, beyond {MAX_SLIP:g}" if peak > MAX_SLIP else None

    def slip(self, distance: float) -> float:
        quarter = (distance / self.wavelength + 0.25) % 1.0
        return self.offset + self.amplitude * (1.0 - 4.0 * abs(quarter - 0.5))
