# SPDX-License-Identifier: Apache-2.0
"""Goes to an end value, fast at first."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import LEVEL, PLACE, SIGNAL, Number, Shape

SHAPE = Shape(
    "relaxation",
    "goes to an end value, fast at first (exponential)",
    ("1.0 - np.exp(-np.maximum(u - {begin}, 0.0) / {length})",),
    (PLACE, LEVEL, SIGNAL),
    (
        Number(
            "length", "u",
            lambda s: s.width * np.geomspace(0.03, 0.6, 10),
            lambda s: (0.01 * s.width, 1.0 * s.width),
            "over which two thirds of it are done",
        ),
    ),
    after_event=True,
)  # fmt: skip
