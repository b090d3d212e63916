# SPDX-License-Identifier: Apache-2.0
"""Constant slip."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import SLIP, Waveform
from flatplank_data.params import param


@dataclass(frozen=True)
class Constant(Waveform):
    """kappa from the start position to the end of the road; with start position 0 from the first
    motion on."""

    name = "constant"
    kappa: float = param(0.0, "slip", bounds=SLIP)

    def slip(self, distance: float) -> float:
        return self.kappa
