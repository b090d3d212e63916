# SPDX-License-Identifier: Apache-2.0
"""Lost motion while gears or teeth cross a gap."""

from __future__ import annotations

import numpy as np
from numba import njit

from flatplank_analysis.effects.base import Motion


def lost_motion(motion: Motion, gap: np.ndarray) -> np.ndarray:
    """Increments of slip travel [m] that are lost while a gap is crossed, both ways.

    The slip travel beyond that of free rolling drags its output behind it at a distance of at
    most the gap (play operator); what the distance grows by is lost.
    """
    data = motion.data
    slip = motion.rolled - motion.travel
    before = (data.since_step < -0.004) & (data.since_step > -0.4) & (data.position > 0.05)
    before = np.broadcast_to(before, slip.shape)
    way = np.where(before, motion.travel, 0.0).sum(axis=-1)
    rate = np.where(before, slip, 0.0).sum(axis=-1) / np.maximum(way, 1e-6)
    extra = np.where(data.since_step > 0.0, slip - rate[..., None] * motion.travel, 0.0)
    ahead = np.cumsum(extra, axis=-1)
    gap = np.ascontiguousarray(np.broadcast_to(gap, (*slip.shape[:-1], 1))[..., 0], dtype=float)
    lost = np.empty_like(slip)
    distance(ahead, gap, lost)
    return np.diff(lost, axis=-1, prepend=0.0)


@njit(cache=True)
def distance(ahead, gap, lost):
    """Distance of a follower that is dragged through a gap; (lanes, runs, samples)."""
    for i in range(ahead.shape[0]):
        for r in range(ahead.shape[1]):
            output = 0.0
            for n in range(ahead.shape[2]):
                output = min(max(output, ahead[i, r, n] - gap[i, r]), ahead[i, r, n] + gap[i, r])
                lost[i, r, n] = ahead[i, r, n] - output
