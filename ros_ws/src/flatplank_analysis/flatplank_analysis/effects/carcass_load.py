# SPDX-License-Identifier: Apache-2.0
"""The carcass gets stiffer or softer with the nominal load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CarcassLoad(TireEffect):
    """The carcass gets stiffer or softer with the nominal load."""

    identifier = "carcass_load"
    title = "Carcass stiffness depends on the load"
    kind = "tire"
    coordinate = "load"
    source = "thesis figure 7.24"
    what = (
        "The relaxation length grows otherwise with the load than the slip stiffness alone "
        "would make it."
    )
    check = "Runs at three loads."
    removes = "Nothing: it belongs to the tire."

    slope: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 2.0),
        screen=0.2,
        matters=0.05,
        note="relative change per relative change of load",
    )

    bend: float = param(
        0.0,
        unit="1",
        bounds=(-0.6, 0.6),
        prior=0.3,
        note="change with the square of the relative change of load",
    )

    def tire(self, tire: Tire) -> None:
        more = tire.data.nominal / tire.data.reference.load - 1.0
        change = 1.0 + self.per_run.slope * more + self.per_run.bend * more**2
        change = np.maximum(change, 0.1)
        tire.x.carcass *= change
        tire.y.carcass *= change
