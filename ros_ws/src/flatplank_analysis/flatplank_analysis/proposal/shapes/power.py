# SPDX-License-Identifier: Apache-2.0
"""Grows as a power of the distance from the lower end."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, PLACE, SIGNAL, Number, Shape

SHAPE = Shape(
    "power",
    "grows as a power of the distance from the lower end; the size is the whole change",
    ("(np.maximum(u - {low}, 0.0) / {width} + 1e-9) ** {power}",),
    (PLACE, LEVEL, SIGNAL),
    (
        Number(
            "power", "1", lambda s: (0.5, 1.5, 2.0, 2.5, 3.0, 4.0), lambda s: (0.3, 5.0),
        ),
    ),
)  # fmt: skip
