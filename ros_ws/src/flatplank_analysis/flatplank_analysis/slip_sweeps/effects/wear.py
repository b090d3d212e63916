# SPDX-License-Identifier: Apache-2.0
"""Tread that wears during the sweeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class Wear(SweepEffect):
    """Friction changes by a share for each kilometre.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) section 1.2.
    """

    identifier = "wear"
    title = "friction changes with the distance rolled"
    kind = "tire"
    coordinate = "distance"
    needs = ("distance",)
    what = "the tread wears, and its surface with it"
    check = "repeat the first sweep at the end"
    removes = "a new tire for each series, or a run-in before it"
    slope: float = param(
        0.0, unit="1/km", bounds=(-0.2, 0.2), screen=0.005, matters=0.001,
        title="friction over distance", symbol="q_μs",
        note="Relative change of the friction for a kilometre.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.grip = s.grip * np.exp(1e-3 * self.slope * s.above("distance"))
