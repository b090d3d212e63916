# SPDX-License-Identifier: Apache-2.0
"""Sinusoidal slip over the road."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import Wave


@dataclass(frozen=True)
class Sine(Wave):
    """offset + amplitude sin(2 pi distance / wavelength)."""

    name = "sine"

    def slip(self, distance: float) -> float:
        return self.offset + self.amplitude * math.sin(math.tau * distance / self.wavelength)
