# SPDX-License-Identifier: Apache-2.0
"""Nothing about zero, growing beyond."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import LEVEL, SIGNAL, Number, Shape

SHAPE = Shape(
    "dead band",
    "is nothing within a band about zero and grows evenly beyond it",
    ("(u - np.clip(u, -{band}, {band})) / {width}",),
    (LEVEL, SIGNAL),
    (
        Number(
            "band", "u", lambda s: s.width * np.linspace(0.06, 0.4, 8),
            lambda s: (0.02 * s.width, 0.45 * s.width),
        ),
    ),
    fits=lambda s: s.crosses,
)  # fmt: skip
