# SPDX-License-Identifier: Apache-2.0
"""The tire is a cone."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class Conicity(TireEffect):
    """The tire is a cone: a lateral force that grows with the load and does not change with
    the direction.
    """

    identifier = "conicity"
    title = "Conicity"
    kind = "tire"
    rarity = 1
    coordinate = "load"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The belt sits off centre: the tire pulls to one side."
    check = "Turn the tire on the rim: conicity changes its sign."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0,
        unit="1",
        bounds=(-0.05, 0.05),
        screen=0.003,
        matters=0.002,
        note="lateral force per load while rolling",
    )

    def signal(self, signal: Signal) -> None:
        data = signal.data
        signal.fy = signal.fy + self.share * data.load * (data.position > 0.0005)
