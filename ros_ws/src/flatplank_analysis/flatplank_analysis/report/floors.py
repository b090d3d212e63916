# SPDX-License-Identifier: Apache-2.0
"""The floor of a condition in the report, by the definition of the search (`discovery.floor`)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flatplank_analysis.discovery.floor import clean_contrasts, contrast_blocks, scatter_of_repeats
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.starts import by_start

ORDERS = (1, 2, 3)
"""harmonics of the wheel angle that differ between start angles and are no scatter"""


def floor_of_runs(force: np.ndarray, angle: np.ndarray, keep: np.ndarray) -> float:
    """Scatter of a single run about the mean of its condition [N], without what turns with the
    wheel; NaN for one run.

    force [N], angle of the wheel in space [rad] (runs, samples); keep: mask (samples,) of those
    that count.
    """
    count = len(force)
    if count < 2 or not keep.any():
        return math.nan
    runs = RunSet(
        names=tuple(map(str, range(count))),
        condition=np.zeros(count, dtype=int),
        condition_names=("",),
        channels=("fx",),
        measured=force[None],
        time=np.broadcast_to(np.arange(force.shape[1], dtype=float), force.shape),
        order=np.arange(count, dtype=float),
    )
    blocks = [np.stack([np.cos(k * angle), np.sin(k * angle)]) for k in ORDERS]
    cleaned = clean_contrasts(runs, force, contrast_blocks(runs, blocks))
    return math.sqrt(scatter_of_repeats(cleaned, runs.groups, keep)[0])


def share_in_mean(starts: Sequence[int]) -> float:
    """Error of the mean of the start angles, relative to the scatter of a single run."""
    groups = by_start(range(len(starts)), starts)
    return math.sqrt(sum(1.0 / len(group) for group in groups)) / len(groups)
