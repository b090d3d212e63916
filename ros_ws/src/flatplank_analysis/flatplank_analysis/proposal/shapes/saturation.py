# SPDX-License-Identifier: Apache-2.0
"""Grows at first and then no more, on either side of zero."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import LEVEL, SIGNAL, Number, Shape

SHAPE = Shape(
    "saturation",
    "grows about zero and stays at an end value on either side",
    ("np.tanh(u / {scale})",),
    (LEVEL, SIGNAL),
    (
        Number(
            "scale", "u", lambda s: s.width * np.geomspace(0.03, 0.5, 8),
            lambda s: (0.015 * s.width, s.width),
        ),
    ),
    fits=lambda s: s.crosses,
)  # fmt: skip
