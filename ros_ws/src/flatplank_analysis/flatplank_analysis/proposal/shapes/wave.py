# SPDX-License-Identifier: Apache-2.0
"""A wave of any period."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape

SHAPE = Shape(
    "wave",
    "waves with a period of its own",
    ("np.cos(wave)", "np.sin(wave)"),
    (PLACE,),
    (
        Number(
            "period", "u",
            lambda s: s.width / np.arange(3.0, 45.0, 0.5),
            lambda s: (s.width / 60.0, s.width / 1.5),
        ),
    ),
    parts=(("wave", "2.0 * np.pi * u / {period}"),),
    where="again every {period}",
)  # fmt: skip
