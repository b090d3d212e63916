# SPDX-License-Identifier: Apache-2.0
"""The zero of Fx creeps from run to run."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class ZeroDriftRuns(TireEffect):
    """The zero of Fx creeps from run to run."""

    identifier = "zero_drift_runs"
    title = "Drift of the zero over the runs"
    kind = "sensor"
    coordinate = "run order"
    source = "thesis 3.1"
    what = "The zero of the bridge creeps during the campaign."
    check = "Compare the readings at standstill before each run."
    removes = "Tare before each run."

    drift: float = param(
        0.0,
        unit="N",
        bounds=(-300.0, 300.0),
        screen=20.0,
        matters=5.0,
        note="from the first to the last run",
    )

    def signal(self, signal: Signal) -> None:
        data = signal.data
        share = data.reference.share(data.runs.order, data.reference.middle)
        signal.fx = signal.fx + self.drift * share[:, None]
