# SPDX-License-Identifier: Apache-2.0
"""The support slides sideways through its play while the lateral force passes zero."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class SupportPlayY(TireEffect):
    """The support slides sideways through its play while the lateral force passes zero."""

    identifier = "support_play_y"
    title = "Play of the support in y"
    kind = "machine"
    coordinate = "distance since the step"
    source = "thesis 3.1: 3 mm in y"
    what = (
        "The rotation support has side play: small lateral forces do not build up until it is "
        "taken up."
    )
    check = "Dial gauge at the support, push sideways."
    removes = "New bearings of the rotation support."
    main = "gap"

    gap: float = param(0.0, unit="m", bounds=(0.0, 6e-3), screen=5e-4, matters=2e-4)

    def tire(self, tire: Tire) -> None:
        tire.y.play += self.per_run.gap
