# SPDX-License-Identifier: Apache-2.0
"""The longitudinal force is read too large by a factor."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class HubGain(TireEffect):
    """The longitudinal force is read too large by a factor."""

    identifier = "hub_gain"
    title = "Gain of the Fx channel"
    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A"
    what = (
        "A wrong calibration factor of Fx. A fitted tire hides it: only a weight on a rope "
        "shows it."
    )
    check = "Pull the standing wheel with a known force."
    removes = "Recalibrate Fx."

    gain: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx * (1.0 + self.gain)
