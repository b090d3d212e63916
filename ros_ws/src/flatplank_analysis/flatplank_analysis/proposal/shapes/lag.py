# SPDX-License-Identifier: Apache-2.0
"""Follows the coordinate late."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import SIGNAL, Number, Shape

SHAPE = Shape(
    "lag",
    "follows it late (first order); the size is that over the whole range",
    ("(follow(u, time, {lag}) - {middle}) / {width}",),
    (SIGNAL,),
    (
        Number(
            "lag", "s", lambda s: np.geomspace(0.3, 60.0, 8), lambda s: (0.05, 200.0),
        ),
    ),
    memory=True,
)  # fmt: skip
