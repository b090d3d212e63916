# SPDX-License-Identifier: Apache-2.0
"""The same everywhere: only what modulates it makes it differ."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import Shape

SHAPE = Shape("constant", "is the same everywhere", ("np.ones_like(u)",), ("none",))
