# SPDX-License-Identifier: Apache-2.0
"""Sinusoidal slip over the road."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import LENGTH, MAX_SLIP, SLIP, Waveform
from flatplank_data.params import param


@dataclass(frozen=True)
class Sine(Waveform):
    """offset + amplitude sin(2 pi distance / wavelength)."""

    name = "sine"
    amplitude: float = param(0.0, "of the slip", bounds=SLIP)
    wavelength: float = param(1.0, "of the sine on the road", unit="m", bounds=LENGTH)
    offset: float = param(0.0, "mean slip", bounds=SLIP)

    def check(self) -> str | None:
        peak = abs(self.offset) + abs(self.amplitude)
        return f"the slip reaches {peak:g}, beyond {MAX_SLIP:g}" if peak > MAX_SLIP else None

    def slip(self, distance: float) -> float:
        return self.offset + self.amplitude * math.sin(math.tau * distance / self.wavelength)
