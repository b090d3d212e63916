# SPDX-License-Identifier: Apache-2.0
"""A first-order low-pass sits in the longitudinal force channel."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.effects.delays import lagged


@dataclass(frozen=True)
class ForceLag(TireEffect):
    """A first-order low-pass sits in the longitudinal force channel."""

    identifier = "force_lag"
    title = "Lag of the force signal"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.2: analogue filters of the measurement hub"
    what = "A filter in the bridge amplifier makes the force channel lag behind."
    check = "Tap the hub and look at the decay; look up the filter setting of the amplifier."
    removes = "A higher cut-off, or the same filter on the motion channels."
    order = 80

    lag: float = param(0.0, unit="s", bounds=(0.0, 2.0), screen=0.05, matters=0.02)

    @classmethod
    def starts(cls) -> tuple[float, ...]:
        return (1.0, 4.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = lagged(signal.fx, signal.data.step_time, self.lag)
