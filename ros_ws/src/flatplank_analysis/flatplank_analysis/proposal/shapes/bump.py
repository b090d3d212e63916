# SPDX-License-Identifier: Apache-2.0
"""Between two places, rising and falling like half a wave."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape

SHAPE = Shape(
    "bump",
    "rises and falls between two places, like half a wave",
    ("np.sin(np.pi * np.clip((u - {start}) / {length}, 0.0, 1.0))",),
    (PLACE,),
    (
        Number(
            "start", "u",
            lambda s: s.shares(*np.arange(0.0, 0.94, 0.02)),
            lambda s: (s.low - 0.1 * s.width, s.high),
            "where it begins",
        ),
        Number(
            "length", "u",
            lambda s: s.width * np.geomspace(0.03, 0.4, 10),
            lambda s: (0.02 * s.width, 0.6 * s.width),
        ),
    ),
    where="from {start} on, over {length}",
)  # fmt: skip
