# SPDX-License-Identifier: Apache-2.0
"""What a waveform is: a parameter set with one pure function of distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from flatplank_data.limits import LIMITS
from flatplank_data.params import Params

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
