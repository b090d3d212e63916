# SPDX-License-Identifier: Apache-2.0
"""A wave of any period."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape, Span


def periods(span: Span) -> np.ndarray:
    """Periods that are looked at: three of them in the range at least."""
    return span.width / np.concatenate([np.arange(3.0, 45.0, 0.5), np.arange(45.0, 116.0, 0.75)])


def ends(span: Span) -> tuple[float, float]:
    """The shortest and the longest period."""
    return span.width / 120.0, span.width / 2.9


SHAPE = Shape(
    "wave",
    "waves with a period of its own",
    ("np.cos(wave)", "np.sin(wave)"),
    (PLACE,),
    (Number("period", "u", periods, ends),),
    parts=(("wave", "2.0 * np.pi * u / {period}"),),
    where="again every {period}",
)  # fmt: skip
