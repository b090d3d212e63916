# SPDX-License-Identifier: Apache-2.0
"""Two waves of neighbouring periods, which swell and fade together."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import PLACE, Number, Shape
from flatplank_analysis.proposal.shapes.wave import ends, periods

SHAPE = Shape(
    "beat",
    "waves with two periods, which swell and fade together",
    ("np.cos(wave)", "np.sin(wave)", "np.cos(other)", "np.sin(other)"),
    (PLACE,),
    (Number("period", "u", periods, ends), Number("second", "u", periods, ends)),
    parts=(("wave", "2.0 * np.pi * u / {period}"), ("other", "2.0 * np.pi * u / {second}")),
    where="again every {period} and every {second}",
)
