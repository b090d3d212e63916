# SPDX-License-Identifier: Apache-2.0
"""Grows evenly over the range."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, PLACE, SIGNAL, Shape

SHAPE = Shape(
    "ramp",
    "changes evenly from one end of the range to the other; the size is the whole change",
    ("(u - {middle}) / {width}",),
    (PLACE, LEVEL, SIGNAL),
)
