# SPDX-License-Identifier: Apache-2.0
"""The plank loses speed in proportion to the longitudinal force, unseen by its encoder."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class SpeedDroop(TireEffect):
    """The plank loses speed in proportion to the longitudinal force, unseen by its encoder."""

    identifier = "speed_droop"
    title = "The plank drive yields to the force"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis table 6.3: about 0.08 % per kN"
    what = (
        "The plank drive gives way under the force. What the encoder on the pinion sees of it "
        "is in the data already; this is what it does not see."
    )
    check = "Second encoder on the plank during a 10 % step."
    removes = "A stiffer speed loop of the plank drive; measured plank position."

    give: float = param(
        0.0,
        unit="1/N",
        bounds=(-4e-6, 4e-6),
        screen=4e-7,
        matters=2e-7,
        note="relative speed per force",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.give += self.per_run.give
