# SPDX-License-Identifier: Apache-2.0
"""The carcass gets stiffer with the pressure."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CarcassPressure(TireEffect):
    """The carcass gets stiffer with the pressure."""

    identifier = "carcass_pressure"
    title = "Carcass stiffness depends on the pressure"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis figure 7.24"
    what = "A soft tire has a soft carcass."
    check = "Runs at two pressures."
    removes = "Nothing: it belongs to the tire."

    slope: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 3.0),
        screen=0.2,
        matters=0.05,
        note="relative change per relative change of pressure",
    )

    def tire(self, tire: Tire) -> None:
        data = tire.data
        change = 1.0 + self.per_run.slope * (data.pressure / data.reference.pressure - 1.0)
        tire.x.carcass *= change
        tire.y.carcass *= change
