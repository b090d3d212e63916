# SPDX-License-Identifier: Apache-2.0
"""The friction drops from run to run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
        order = tire.data.runs.order
        share = (order - order.min()) / max(float(np.ptp(order)), 1.0)
        tire.friction *= 1.0 - self.loss * share[:, None]
