# SPDX-License-Identifier: Apache-2.0
"""A braking force in proportion to the load while the tire rolls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class RollingResistance(TireEffect):
    """A braking force in proportion to the load while the tire rolls."""

    identifier = "rolling_resistance"
    title = "Rolling resistance"
    kind = "tire"
    coordinate = "load"
    source = "thesis 6.3: small negative force at free rolling"
    what = (
        "The rolling tire resists. The base fits a constant force while rolling already; runs "
        "at other loads show the difference."
    )
    check = "Free-rolling runs at three loads."
    removes = "Nothing: it belongs to the tire."

    share: float = param(0.0, unit="1", bounds=(-0.05, 0.05), screen=0.005, matters=0.002)

    def signal(self, signal: Signal) -> None:
        data = signal.data
        rolling = 1.0 - np.exp(-np.maximum(data.position, 0.0) / 0.005)
        signal.fx = signal.fx - self.share * data.load * rolling
