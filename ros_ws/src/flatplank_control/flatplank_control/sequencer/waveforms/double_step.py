# SPDX-License-Identifier: Apache-2.0
"""Two steps of slip, for instance a preload and then the measured step."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import LENGTH, SLIP, Waveform
from flatplank_data.params import param


@dataclass(frozen=True)
class DoubleStep(Waveform):
    """kappa_1 for `length`, then kappa_2."""

    name = "double_step"
    kappa_1: float = param(0.0, "slip after the first step", bounds=SLIP)
    kappa_2: float = param(0.0, "slip after the second step", bounds=SLIP)
    length: float = param(1.0, "from the first step to the second", unit="m", bounds=LENGTH)

    def slip(self, distance: float) -> float:
        return self.kappa_1 if distance < self.length else self.kappa_2
