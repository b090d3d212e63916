# SPDX-License-Identifier: Apache-2.0
"""The friction drops from run to run."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class Wear(TireEffect):
    """The friction drops from run to run."""

    identifier = "wear"
    title = "Wear of the road surface over the runs"
    kind = "machine"
    coordinate = "run order"
    source = "thesis 3.1: the sandpaper wears during a campaign"
    what = "The sandpaper loses grip during the campaign; runs with much sliding show it."
    check = "Repeat the first run at the end."
    removes = "New sandpaper; order of the runs at random, so that wear is no trend in the slip."

    loss: float = param(
        0.0,
        unit="1",
        bounds=(-0.3, 0.5),
        screen=0.02,
        matters=0.01,
        note="friction lost from the first to the last run",
    )

    def tire(self, tire: Tire) -> None:
        data = tire.data
        share = data.reference.share(data.runs.order, data.reference.first)
        tire.friction *= 1.0 - self.loss * share[:, None]
