# SPDX-License-Identifier: Apache-2.0
"""A wave three times per turn."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import ANGLE, Shape

SHAPE = Shape(
    "harmonic 3", "waves three times per turn", ("np.cos(3 * u)", "np.sin(3 * u)"), (ANGLE,)
)
