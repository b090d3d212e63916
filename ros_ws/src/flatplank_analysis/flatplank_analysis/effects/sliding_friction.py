# SPDX-License-Identifier: Apache-2.0
"""The friction depends on the speed with which the rubber slides."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class SlidingFriction(TireEffect):
    """The friction depends on the speed with which the rubber slides."""

    identifier = "sliding_friction"
    title = "Friction falls with the sliding speed"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 2.3; with one plank speed it cannot be told from the force law"
    what = "Rubber loses (or gains) grip with the sliding speed."
    check = "The same slips at 0.0015 m/s."
    removes = "Nothing: it belongs to the tire; the law needs it when the speed changes."

    drop: float = param(
        0.0,
        unit="1",
        bounds=(-0.5, 0.9),
        screen=0.05,
        matters=0.02,
        note="loss of friction far above 5 % of 0.03 m/s",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.slide += self.per_run.drop
