# SPDX-License-Identifier: Apache-2.0
"""Triangular slip over the road."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_control.sequencer.waveforms.base import Wave


@dataclass(frozen=True)
class Triangle(Wave):
    """offset + amplitude times a triangle of period `wavelength` that starts upwards from 0."""

    name = "triangle"

    def slip(self, distance: float) -> float:
        quarter = (distance / self.wavelength + 0.25) % 1.0
        return self.offset + self.amplitude * (1.0 - 4.0 * abs(quarter - 0.5))
