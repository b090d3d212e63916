# SPDX-License-Identifier: Apache-2.0
"""Slip over the travel of the road or over the rolled distance."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class SlipDefinition(TireEffect):
    """Slip over the travel of the road or over the rolled distance."""

    identifier = "slip_definition"
    title = "Definition of the slip"
    kind = "tire"
    coordinate = "slip level"
    source = "the base has it as its parameter denom"
    what = "Theoretical slip kappa/(1 + kappa) or practical slip kappa: a choice of the model."
    check = "Nothing to check on the machine."
    removes = "The base fits it already."

    more: float = param(0.0, unit="1", bounds=(-1.5, 1.5), screen=0.3, matters=0.2)

    def tire(self, tire: Tire) -> None:
        tire.x.denom += self.per_run.more
