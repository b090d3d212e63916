# SPDX-License-Identifier: Apache-2.0
"""Off on one side of a value, on beyond it."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, PLACE, SIGNAL, Number, Shape

SHAPE = Shape(
    "step",
    "is there beyond one value only",
    ("0.5 + 0.5 * np.tanh((u - {at}) / {edge})",),
    (PLACE, LEVEL, SIGNAL),
    (
        Number(
            "at", "u",
            lambda s: s.shares(*(0.06 + 0.04 * i for i in range(23))),
            lambda s: (s.low, s.high),
            "where it begins",
        ),
    ),
    where="beyond {at}",
)  # fmt: skip
