# SPDX-License-Identifier: Apache-2.0
"""Base of the waveforms: a parameter set with one pure function of distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from flatplank_data.limits import LIMITS
from flatplank_data.params import Params, param

SLIP = LIMITS["kappa"].bounds
MAX_SLIP = SLIP[1]
LENGTH = (1e-3, 100.0)


@dataclass(frozen=True)
class Waveform(Params):
    """Slip over the distance since the start position; before it the tire rolls freely."""

    name: ClassVar[str]

    def slip(self, distance: float) -> float:
        """kappa [-] at `distance` >= 0 [m]; ISO W, driving > 0."""
        raise TypeError(f"{type(self).__name__} must define slip")


@dataclass(frozen=True)
class Wave(Waveform):
    """Periodic slip over the road."""

    amplitude: float = param(0.0, "of the slip", bounds=SLIP)
    wavelength: float = param(1.0, "of the wave on the road", unit="m", bounds=LENGTH)
    offset: float = param(0.0, "mean slip", bounds=SLIP)

    def check(self) -> str | None:
        """Reason when the wave exceeds the largest slip, else None."""
        peak = abs(self.offset) + abs(self.amplitude)
        return f"the slip reaches {peak:g}, beyond {MAX_SLIP:g}" if peak > MAX_SLIP else None
