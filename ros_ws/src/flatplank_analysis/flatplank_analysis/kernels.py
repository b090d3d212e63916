# SPDX-License-Identifier: Apache-2.0
"""Compiles the inner loops of the analysis into numba's cache, by calling each with empty data."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.contact_patch import kernel as contact_patch
from flatplank_analysis.effects import gaps
from flatplank_analysis.models.nonlinear import march


def compile_all() -> None:
    """Compile all inner loops during set-up, so that the first diagnosis does not wait for it."""
    none, node, pair = np.zeros(0), np.zeros((0, 1)), np.zeros((2, 0, 1))
    params = np.zeros((2, 0, contact_patch.WIDTH))
    blocks = contact_patch.blocks_of(np.arange(0))
    states = contact_patch.rest(blocks, params, none)
    for across in (None, 1):
        contact_patch.sweep(
            blocks, True, True, node, pair, node, node, node, params, none, 1.0, pair.copy(),
            across,
        )  # fmt: skip
        contact_patch.one_node(
            states, blocks, node, pair, node, node, node, 1.0, pair.copy(), across
        )  # fmt: skip
    cube = np.zeros((0, 1, 1))
    gaps.play_distance(cube, node, node, cube.copy())
    march(node, node, node, node, node, cube, 0.0, 1.0, cube, True)
