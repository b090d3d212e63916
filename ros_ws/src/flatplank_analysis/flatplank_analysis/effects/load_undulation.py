# SPDX-License-Identifier: Apache-2.0
"""The plank is not level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect
from flatplank_analysis.effects.waves import periods


@dataclass(frozen=True)
class LoadUndulation(TireEffect):
    """The plank is not level: the load on the tire waves with the plank position."""

    identifier = "load_undulation"
    title = "Load undulation over the plank that the hub does not see"
    kind = "machine"
    coordinate = "plank position"
    source = "thesis 6.3, figure 6.6: support bearings and plank undulation"
    what = "Bearings and bending of the plank change the load at fixed plank positions."
    check = "Dial gauge along the plank; reverse the direction: the places stay."
    removes = "Level the plank; measure the load at the contact."

    cos: float = param(0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005)
    sin: float = param(0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005)
    period: float = param(0.5, unit="m", bounds=(0.08, 2.5), note="in plank travel")

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        found = periods(runs, residual, 0.08, 2.5)
        return [{"period": p} for p in [*found, 0.35, 0.7, 1.4]]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 100

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def tire(self, tire: Tire) -> None:
        phase = 2.0 * np.pi * tire.data.position / self.period
        tire.load *= 1.0 + self.cos * np.cos(phase) + self.sin * np.sin(phase)
