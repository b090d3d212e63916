# SPDX-License-Identifier: Apache-2.0
"""Friction that differs along the road, from run to run, or with the sliding speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class WornPatch(TireEffect):
    """Less friction at one place of the plank; grows with the slip.

    Source: thesis 3.1: worn sandpaper at 0.15, 2.35 and 3.90 m
    """

    identifier = "worn_patch"
    title = "Worn patch of the road surface"
    kind = "machine"
    coordinate = "plank position"
    source = "thesis 3.1: worn sandpaper at 0.15, 2.35 and 3.90 m"
    what = "The sandpaper is worn or loose at one place of the plank."
    check = "Look at the place; move the step to another position: the dip stays on the plank."
    removes = "New sandpaper."
    main = "depth"
    instances = 3

    depth: float = param(
        0.0,
        unit="1",
        bounds=(-0.3, 0.7),
        screen=0.05,
        matters=0.01,
        note="relative loss of friction",
    )
    position: float = param(2.0, unit="m", bounds=(0.0, 4.2))
    width: float = param(0.2, unit="m", bounds=(0.03, 0.8))

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        last = float(runs.coordinates["plank position"].values.max())
        return [{"position": float(p), "width": 0.2} for p in np.arange(0.2, last, 0.16)]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 30

    def tire(self, tire: Tire) -> None:
        away = (tire.data.position - self.position) / (0.5 * self.width)
        tire.friction *= 1.0 - self.depth * np.exp(-(away**4))


@dataclass(frozen=True)
class Wear(TireEffect):
    """The friction drops from run to run.

    Source: thesis 3.1: the sandpaper wears during a campaign
    """

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


@dataclass(frozen=True)
class SlidingFriction(TireEffect):
    """The friction depends on the speed with which the rubber slides.

    Source: thesis 2.3; with one plank speed it cannot be told from the force law
    """

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
