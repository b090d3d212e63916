# SPDX-License-Identifier: Apache-2.0
"""Friction that follows the speed of the belt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class GripOverSpeed(SweepEffect):
    """Friction changes by a share for each metre per second.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) equation 4.E7, LMUV.
    """

    identifier = "grip_speed"
    title = "friction follows the speed"
    kind = "tire"
    coordinate = "speed"
    needs = ("speed",)
    what = "rubber that slides faster has another friction"
    check = "sweep at two speeds"
    removes = "give friction its coefficient of speed"
    slope: float = param(
        0.0, unit="s/m", bounds=(-0.1, 0.1), screen=0.002, matters=0.0005,
        title="friction over speed", symbol="q_μV",
        note="Relative change of the friction for a metre per second.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.grip = s.grip * np.exp(self.slope * s.above("speed"))
