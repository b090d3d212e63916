# SPDX-License-Identifier: Apache-2.0
"""A wave that dies away after an event at zero."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape

SHAPE = Shape(
    "ringing",
    "waves after the event and dies away",
    ("fading * np.cos(wave)", "fading * np.sin(wave)"),
    (PLACE,),
    (
        Number(
            "period", "u",
            lambda s: s.width / np.arange(4.0, 40.0, 1.0),
            lambda s: (s.width / 60.0, s.width),
        ),
        Number(
            "fade", "u",
            lambda s: s.width * np.array([0.05, 0.1, 0.2, 0.35]),
            lambda s: (0.01 * s.width, 2.0 * s.width),
            "length over which it falls to a third",
        ),
    ),
    fits=lambda s: s.crosses,
    parts=(
        ("wave", "2.0 * np.pi * u / {period}"),
        ("fading", "(u > 0.0) * np.exp(-np.maximum(u, 0.0) / {fade})"),
    ),
    where="again every {period}, falling to a third over {fade}",
)  # fmt: skip
