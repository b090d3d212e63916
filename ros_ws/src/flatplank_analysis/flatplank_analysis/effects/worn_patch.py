# SPDX-License-Identifier: Apache-2.0
"""Less friction at one place of the plank; grows with the slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect

BEFORE, AFTER = 0.1, 0.2
"""[m] about a step that all runs have in common: no patch is looked for"""


@dataclass(frozen=True)
class WornPatch(TireEffect):
    """Less friction at one place of the plank; grows with the slip."""

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
    local = True

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
    blur: float = param(
        0.04,
        unit="m",
        bounds=(0.005, 0.1),
        note="half length over which an edge comes in: that of the contact, or sharper",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """Places over the plank; not where all runs step, for there a patch is not to be told
        from the form of the tire's transient."""
        last = float(runs.coordinates["plank position"].values.max())
        steps = runs.facts.get("step", np.array([np.nan]))
        steps = steps[np.isfinite(steps)]
        step = float(np.median(steps)) if len(steps) and np.ptp(steps) < 0.05 else -1.0
        places = np.arange(0.2, last, 0.16)
        places = places[(places < step - BEFORE) | (places > step + AFTER)]
        return [{"position": float(p), "width": 0.2} for p in places]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 30

    def tire(self, tire: Tire) -> None:
        away = tire.data.position - self.position
        cover = _edge((away + 0.5 * self.width) / self.blur)
        cover = cover - _edge((away - 0.5 * self.width) / self.blur)
        tire.friction *= 1.0 - self.depth * cover


def _edge(u: np.ndarray) -> np.ndarray:
    """Share of a parabolic contact pressure that has passed an edge, u = -1 .. 1."""
    u = np.clip(u, -1.0, 1.0)
    return 0.5 + 0.75 * u - 0.25 * u**3
