# SPDX-License-Identifier: Apache-2.0
"""A tire that follows its slip angle late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class Relaxation(SweepEffect):
    """The slip angle acts a relaxation length late.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) section 7.2.
    """

    identifier = "relaxation"
    title = "side force follows the slip angle late"
    kind = "tire"
    coordinate = "rate"
    needs = ("rate", "alpha")
    what = "the carcass takes a rolled length to deflect: up and down differ"
    check = "sweep at half the rate: the loop is half as wide"
    removes = "sweep more slowly, or use the mean of up and down"
    length: float = param(
        0.0, unit="m", bounds=(0.0, 3.0), screen=0.1, matters=0.02,
        title="relaxation length", symbol="σ", note="Road by which the slip angle acts late.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.alpha = s.alpha - self.length * s.rate / s.speed
