# SPDX-License-Identifier: Apache-2.0
"""Longitudinal and lateral slip share the friction."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CombinedSlip(TireEffect):
    """Longitudinal and lateral slip share the friction."""

    identifier = "combined_slip"
    title = "Combined slip"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3: friction ellipse, figures 6.12 and 6.13"
    what = "Friction that is used in one direction is missing in the other."
    check = "Runs at 5 deg of side slip."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0, unit="1", bounds=(0.0, 2.0), screen=0.3, matters=0.1, note="1: isotropic patch"
    )

    def tire(self, tire: Tire) -> None:
        tire.x.combine += self.per_run.share
        tire.y.combine += self.per_run.share
