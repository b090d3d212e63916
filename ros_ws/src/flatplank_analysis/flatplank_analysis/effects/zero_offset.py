# SPDX-License-Identifier: Apache-2.0
"""The longitudinal force is not zero at standstill."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class ZeroOffset(TireEffect):
    """The longitudinal force is not zero at standstill.

    Source: thesis Appendix A
    """

    identifier = "zero_offset"
    title = "Zero error of Fx"
    kind = "sensor"
    coordinate = "time"
    source = "thesis Appendix A"
    what = "The bridge was not set to zero, or the standing tire is strained."
    check = "Read Fx with the wheel lifted."
    removes = "Tare with the wheel lifted."

    zero: float = param(0.0, unit="N", bounds=(-300.0, 300.0), screen=10.0, matters=5.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.zero
