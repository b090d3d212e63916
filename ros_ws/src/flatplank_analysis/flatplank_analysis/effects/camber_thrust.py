# SPDX-License-Identifier: Apache-2.0
"""Camber acts like a slip angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, TireEffect


@dataclass(frozen=True)
class CamberThrust(TireEffect):
    """Camber acts like a slip angle."""

    identifier = "camber_thrust"
    title = "Camber thrust"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3, figures 6.16 and 6.17"
    what = "A cambered tire pulls sideways."
    check = "Runs at two camber angles."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0,
        unit="1",
        bounds=(-0.5, 0.5),
        screen=0.05,
        matters=0.01,
        note="equivalent slip angle per camber",
    )

    def motion(self, motion: Motion) -> None:
        camber = np.sin(motion.data.gamma)[:, None]
        motion.lateral -= self.share * camber * motion.travel
