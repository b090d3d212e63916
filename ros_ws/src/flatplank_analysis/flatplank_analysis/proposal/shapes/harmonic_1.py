# SPDX-License-Identifier: Apache-2.0
"""A wave once per turn."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import ANGLE, Shape

SHAPE = Shape("harmonic 1", "waves once per turn", ("np.cos(1 * u)", "np.sin(1 * u)"), (ANGLE,))
