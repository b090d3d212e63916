# SPDX-License-Identifier: Apache-2.0
"""Grows with the size, whatever the sign."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, SIGNAL, Shape

SHAPE = Shape(
    "size",
    "grows with the size, whatever the sign; the size is that over the whole range",
    ("np.abs(u) / {width}",),
    (LEVEL, SIGNAL),
    fits=lambda s: s.crosses,
)
