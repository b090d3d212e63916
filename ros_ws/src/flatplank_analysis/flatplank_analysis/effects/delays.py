# SPDX-License-Identifier: Apache-2.0
"""Delays of a signal, in lanes."""

from __future__ import annotations

import numpy as np


def shifted(values: np.ndarray, time: np.ndarray, delay: np.ndarray) -> np.ndarray:
    """values(time - delay), the ends held; shapes (lanes, runs, samples), (runs, samples)."""
    out = np.empty_like(values)
    for lane, row in enumerate(np.broadcast_to(delay, (len(values), 1, 1))[:, 0, 0]):
        for r, t in enumerate(time):
            out[lane, r] = np.interp(t - row, t, values[lane, r])
    return out


def lagged(values: np.ndarray, step: np.ndarray, lag: np.ndarray) -> np.ndarray:
    """First-order low-pass, exact for straight pieces between the nodes."""
    lag = np.broadcast_to(lag, (len(values), 1, 1))
    keep = np.exp(-step / np.maximum(lag, 1e-9))
    slope = np.diff(values, axis=-1, prepend=values[..., :1]) / np.maximum(step, 1e-9)
    behind = slope * lag
    out = values.copy()
    for n in range(1, values.shape[-1]):
        rest = out[..., n - 1] - values[..., n - 1] + behind[..., n]
        out[..., n] = values[..., n] - behind[..., n] + rest * keep[..., n]
    return out
