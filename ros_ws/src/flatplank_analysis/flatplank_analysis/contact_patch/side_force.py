# SPDX-License-Identifier: Apache-2.0
"""Fy before the plank moves: a wheel that is turned or tilted under load is bent already."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flatplank_analysis.contact_patch.grid import START

STRAIGHT = np.radians(0.25)
"""[rad] a wheel that is neither turned nor tilted"""
SURE = 5.0
"""standard errors beyond which a force at rest is one and no noise"""


def side_force(
    fy: np.ndarray | None, position: np.ndarray, facts: Mapping[str, np.ndarray]
) -> np.ndarray:
    """Fy of the standing wheel (runs,) [N]: the mean over all runs of a setting, less the zero of
    the channel, which straight wheels show; 0 where it is no more than noise.

    fy [N] and position [m] (runs, samples), fy None where it was not recorded; facts (runs,):
    alpha and gamma [rad], nominal load [N].
    """
    out = np.zeros(len(position))
    if fy is None:
        return out
    standing = position < position[:, :1] + START
    level = np.where(standing, fy, 0.0).sum(axis=1) / standing.sum(axis=1)
    settings = np.stack([facts["alpha"], facts["gamma"], facts["nominal"]], axis=1)
    straight = np.abs(settings[:, :2]).max(axis=1) < STRAIGHT
    level = level - (level[straight].mean() if straight.any() else 0.0)
    for setting in np.unique(settings[~straight], axis=0):
        rows = np.flatnonzero((settings == setting).all(axis=1))
        mean = float(level[rows].mean())
        if len(rows) > 1 and abs(mean) > SURE * level[rows].std(ddof=1) / np.sqrt(len(rows)):
            out[rows] = mean
    return out
