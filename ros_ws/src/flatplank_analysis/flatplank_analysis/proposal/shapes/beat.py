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
    ("np.cos(wave)", "np.sin(wave)", "np.cos(other)", "np.sin(other)"),
    (PLACE,),
    (Number("period", "u", _periods, _ends), Number("second", "u", _periods, _ends)),
    parts=(("wave", "2.0 * np.pi * u / {period}"), ("other", "2.0 * np.pi * u / {second}")),
    where="again every {period} and every {second}",
)
