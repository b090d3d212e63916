# SPDX-License-Identifier: Apache-2.0
"""Coefficients of the aligning moment beyond those of its stages, where the sweeps have the levels
that tell them from the others.

The factor of the residual moment over the slip angle needs the curve alone. What is square in the
load needs a load more than it has terms, so that a load checks it; what turns its sign with the
camber needs cambers to both sides, and what is square in it three sizes of the camber.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatplank_analysis.identify.mf.information import levels_of
from flatplank_analysis.identify.mf.points import SteadyPoints
from flatplank_tire.magic_formula import NOT_OF

CAMBERS = "size of the camber"
NEEDS: dict[str, dict[str, int]] = {
    "QBZ9": {"alpha": 2},
    "QBZ10": {"alpha": 2, "fz": 2},
    "QEZ4": {"alpha": 2},
    "QBZ3": {"fz": 4},
    "QEZ3": {"fz": 4},
    "QBZ4": {"gamma": 3},
    "QEZ5": {"gamma": 3},
    "QHZ4": {"gamma": 2, "fz": 2},
    "QDZ10": {CAMBERS: 3},
    "QDZ11": {CAMBERS: 3, "fz": 2},
    "PPZ2": {"gamma": 2, "pressure": 2},
}
"""coefficient -> axis and its least number of levels"""


def further(points: SteadyPoints, law: str) -> tuple[str, ...]:
    """Further coefficients of a law that these points can determine; none without Mz."""
    points = points.with_output("mz")
    count = {axis: len(levels_of(points, axis)) for axis in ("alpha", "fz", "gamma", "pressure")}
    sizes = replace(points, gamma=np.abs(points.gamma))
    count[CAMBERS] = len(levels_of(sizes, "gamma"))
    return tuple(
        name for name, needs in NEEDS.items()
        if name not in NOT_OF[law] and all(count[axis] >= n for axis, n in needs.items())
    )  # fmt: skip
