# SPDX-License-Identifier: Apache-2.0
"""Two waves of neighbouring periods, which swell and fade together."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape, Span


def _periods(span: Span) -> np.ndarray:
    return span.width / np.arange(3.0, 45.0, 0.5)


def _ends(span: Span) -> tuple[float, float]:
    return span.width / 60.0, span.width / 1.5


SHAPE = Shape(
    "beat",
    "waves with two periods, which swell and fade together",
    (
        "np.cos(2.0 * np.pi * u / {period})",
        "np.sin(2.0 * np.pi * u / {period})",
        "np.cos(2.0 * np.pi * u / {second})",
        "np.sin(2.0 * np.pi * u / {second})",
    ),
    (PLACE,),
    (Number("period", "u", _periods, _ends), Number("second", "u", _periods, _ends)),
)
