# SPDX-License-Identifier: Apache-2.0
"""One step of slip: the measurement of thesis chapter 6."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import LENGTH, SLIP, Waveform
from flatplank_data.params import param


@dataclass(frozen=True)
class Step(Waveform):
    """kappa after the step; back to free rolling after `length`."""

    name = "step"
    kappa: float = param(0.0, "slip after the step", bounds=SLIP)
    length: float = param(100.0, "of the step", unit="m", bounds=LENGTH)

    def slip(self, distance: float) -> float:
        return self.kappa if distance < self.length else 0.0
