# SPDX-License-Identifier: Apache-2.0
"""The plank slides through its play while the force passes zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire
from flatplank_analysis.effects.gap import Gap


@dataclass(frozen=True)
class RoadPlay(Gap):
    """The plank slides through its play while the force passes zero."""

    identifier = "road_play"
    title = "Play of the road in x"
    kind = "machine"
    source = "thesis 3.1 and 7.2: 1.15 mm of longitudinal play, cut to 0.05 mm later"
    what = (
        "The plank can slide by the gap between its drive and its stop. The force of the tire "
        "holds it on one side; when the force changes its sign the plank crosses the gap and "
        "the force rests at zero meanwhile. Dry friction may keep it where the last run left it: "
        "then repeats of one condition begin on either side of the gap."
    )
    check = (
        "Dial gauge between plank and rack, push and pull the plank by hand with the drive "
        "locked. A driving step out of a driving preload shows no dead travel."
    )
    removes = "Shim or preload the coupling between plank and rack; or keep the force on one side."

    rest: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 1.0),
        note="where in the gap a run starts: -1 braking, +1 driving side; with kept the first",
    )
    at: float = param(
        0.0,
        unit="N",
        bounds=(-150.0, 150.0),
        note="force at which it moves: dry friction of the plate",
    )

    kept: float = param(
        0.0,
        unit="1",
        bounds=(0.0, 1.0),
        note="1: a run starts where the one before it left the plank, held by dry friction",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"kept": k, "at": at} for k in (0.0, 1.0) for at in (0.0, 50.0)]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 4

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("kept",)

    def tire(self, tire: Tire) -> None:
        own, x, before = self.per_run, tire.x, tire.data.side_before
        kept = own.kept > 0.5
        x.play += own.gap
        x.play_rest += np.where(kept & (before != 0.0), before, own.rest)
        x.play_at = np.where(kept, 0.0, own.at)
        x.play_hold = np.where(kept, np.abs(own.at), 0.0)
