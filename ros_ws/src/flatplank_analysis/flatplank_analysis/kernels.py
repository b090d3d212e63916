# SPDX-License-Identifier: Apache-2.0
"""Compiles the inner loops of the analysis into numba's cache, by calling each with nothing."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.effects import lost_motion
from flatplank_analysis.models import kernel as models
from flatplank_analysis.tirebase import kernel as tirebase


def compile_all() -> None:
    """As the set-up does, so that the first diagnosis does not wait for it."""
    none, node, pair = np.zeros(0), np.zeros((0, 1)), np.zeros((2, 0, 1))
    block = np.zeros((2, 0, tirebase.WIDTH))
    todo = np.zeros((2, 0), dtype=bool)
    tirebase.sweep(
        node, pair, node, node, node, block, none, 1.0, todo, pair.copy(), np.int64(0), np.int64(0)
    )
    tirebase.one_node(
        tirebase.rest(block), none, np.zeros((2, 0)), none, none, none, block, none, 1.0
    )
    cube = np.zeros((0, 1, 1))
    lost_motion.distance(cube, node, cube.copy())
    if models.compiled is not None:
        models.compiled(node, node, node, node, node, node, node, cube, 0.0, 1.0, cube, True)
