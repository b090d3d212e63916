# SPDX-License-Identifier: Apache-2.0
"""One value on the way forward, another on the way back."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import SIGNAL, Number, Shape

SHAPE = Shape(
    "play",
    "differs on the way forward and on the way back (play operator)",
    ("play(u, {gap})",),
    (SIGNAL,),
    (
        Number(
            "gap", "u", lambda s: s.width * np.geomspace(0.01, 0.5, 8),
            lambda s: (0.005 * s.width, s.width),
        ),
    ),
    memory=True,
)  # fmt: skip
