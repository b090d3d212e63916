# SPDX-License-Identifier: Apache-2.0
"""Shapes with a memory along the run; arrays (..., samples)."""

from __future__ import annotations

import numpy as np


def play(u: np.ndarray, width: np.ndarray | float) -> np.ndarray:
    """Distance to a follower that is dragged through a gap of this width, over half of it.

    -1 .. 1: what goes forward differs from what goes back (play operator).
    """
    half = 0.5 * np.asarray(width)
    u = np.broadcast_to(u, np.broadcast_shapes(np.shape(u), np.shape(half)))
    half = np.broadcast_to(half, (*u.shape[:-1], 1))[..., 0]
    out = np.empty(u.shape)
    follower = u[..., 0].copy()
    for n in range(u.shape[-1]):
        follower = np.minimum(np.maximum(follower, u[..., n] - half), u[..., n] + half)
        out[..., n] = u[..., n] - follower
    return out / half[..., None]


def follow(u: np.ndarray, time: np.ndarray, lag: np.ndarray | float) -> np.ndarray:
    """What follows u with a first-order lag [s]; it begins where u begins."""
    lag = np.asarray(lag)
    u = np.broadcast_to(u, np.broadcast_shapes(np.shape(u), np.shape(lag)))
    step = np.diff(time, axis=-1, prepend=time[..., :1])
    keep = np.exp(-step / np.maximum(lag, 1e-9))
    out = np.array(u, dtype=float)
    for n in range(1, u.shape[-1]):
        out[..., n] = u[..., n] + (out[..., n - 1] - u[..., n]) * keep[..., n]
    return out
