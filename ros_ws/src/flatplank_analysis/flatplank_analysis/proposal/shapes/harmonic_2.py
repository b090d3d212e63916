# SPDX-License-Identifier: Apache-2.0
"""A wave twice per turn."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import ANGLE, Shape

SHAPE = Shape("harmonic 2", "waves twice per turn", ("np.cos(2 * u)", "np.sin(2 * u)"), (ANGLE,))
