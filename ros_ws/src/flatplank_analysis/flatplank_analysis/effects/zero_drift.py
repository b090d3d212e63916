# SPDX-License-Identifier: Apache-2.0
"""The zero of Fx creeps with time during every run."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class ZeroDrift(TireEffect):
    """The zero of Fx creeps with time during every run."""

    identifier = "zero_drift"
    title = "Drift of the zero during a run"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1: warming-up of the bridge amplifiers"
    what = "The bridge amplifier warms up: the zero creeps during the run."
    check = "Record the standing wheel for five minutes."
    removes = "Let the amplifier warm up; tare before each run."

    drift: float = param(0.0, unit="N/s", bounds=(-3.0, 3.0), screen=0.1, matters=0.04)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.drift * signal.data.runs.time
