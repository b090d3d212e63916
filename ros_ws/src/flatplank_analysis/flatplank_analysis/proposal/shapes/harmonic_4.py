# SPDX-License-Identifier: Apache-2.0
"""A wave four times per turn."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import ANGLE, Shape

SHAPE = Shape(
    "harmonic 4", "waves four times per turn", ("np.cos(4 * u)", "np.sin(4 * u)"), (ANGLE,)
)
