# SPDX-License-Identifier: Apache-2.0
"""The deflection of the carcass grows faster than the force."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CarcassSoftening(TireEffect):
    """The deflection of the carcass grows faster than the force."""

    identifier = "carcass_softening"
    title = "The carcass softens with the force"
    kind = "tire"
    coordinate = "distance since the step"
    law = True
    source = "the tire itself, not the thesis's machine"
    what = "A carcass is not a straight spring: large forces deflect it more."
    check = "Stiffness test of the standing tire to large forces."
    removes = "Nothing: it belongs to the tire."

    soften: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 2.0),
        screen=0.1,
        matters=0.05,
        note="relative compliance added at 4 kN",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.soften += self.per_run.soften
