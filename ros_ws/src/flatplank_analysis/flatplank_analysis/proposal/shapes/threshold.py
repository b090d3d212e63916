# SPDX-License-Identifier: Apache-2.0
"""Nothing up to a value, growing beyond it."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, PLACE, SIGNAL, Number, Shape

SHAPE = Shape(
    "threshold",
    "is nothing up to one value and grows evenly beyond it; the size is that over the whole range",
    ("np.maximum(u - {at}, 0.0) / {width}",),
    (PLACE, LEVEL, SIGNAL),
    (
        Number(
            "at", "u",
            lambda s: s.shares(*(0.1 + 0.04 * i for i in range(20))),
            lambda s: (s.low, s.high - 0.05 * s.width),
            "where it begins",
        ),
    ),
    where="beyond {at}",
)  # fmt: skip
