# SPDX-License-Identifier: Apache-2.0
"""One value on either side of zero."""

from __future__ import annotations

from flatplank_analysis.proposal.shapes.base import LEVEL, SIGNAL, Shape

SHAPE = Shape(
    "sign", "changes its sign with that of it", ("np.tanh(u / {edge})",), (LEVEL, SIGNAL),
    fits=lambda s: s.crosses,
)  # fmt: skip
