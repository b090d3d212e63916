# SPDX-License-Identifier: Apache-2.0
"""One zero-phase filter for inputs and outputs, and the nodes on which a run is computed.

Fine nodes (20 Hz at 0.03 m/s) after the start and after the step, coarse ones (5 Hz) elsewhere.
Nodes lie at equal plank positions in all runs, so that repeats can be compared node by node.
"""

from __future__ import annotations

import numpy as np

SPEED = 0.03
"""[m/s] speed at which node distances and the filter are stated"""
FINE = 0.05 * SPEED
COARSE = 0.2 * SPEED
FILTER = 0.075
"""[s] standard deviation of the Gaussian filter at SPEED"""
SAMPLE = 0.05
"""[s] block length at SPEED; faster recordings are averaged in blocks first"""


def blocks(values: np.ndarray, count: int) -> np.ndarray:
    """Means of `count` samples, shape (samples // count, ...)."""
    rows = len(values) // count
    shape = (rows, count, *values.shape[1:])
    return values[: rows * count].reshape(shape).mean(axis=1)


def gaussian(values: np.ndarray, sigma: float) -> np.ndarray:
    """Zero-phase Gaussian along axis 0, `sigma` in samples; ends are continued by reflection
    about the end value (odd), so that a ramp stays a ramp."""
    if sigma < 0.2:
        return values
    reach = min(int(np.ceil(4.0 * sigma)), len(values) - 1)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    head = 2.0 * values[0] - values[reach:0:-1]
    tail = 2.0 * values[-1] - values[-2 : -reach - 2 : -1]
    padded = np.concatenate([head, values, tail])
    out = np.zeros_like(values)
    for i, weight in enumerate(kernel):
        out += weight * padded[i : i + len(values)]
    return out


def smooth_columns(time: np.ndarray, columns: np.ndarray, speed: float) -> tuple:
    """Filter and thin out one run: (time, columns) with columns of shape (samples, channels)."""
    dt = float(np.median(np.diff(time)))
    stretch = SPEED / max(speed, 1e-4)
    count = max(1, int(SAMPLE * stretch / dt + 0.25))
    time, columns = blocks(time, count), blocks(columns, count)
    return time, gaussian(columns, FILTER * stretch / (dt * count))


def node_positions(step: float, end: float) -> np.ndarray:
    """Plank positions [m] of the nodes of a run with a step at `step` (NaN: none)."""
    starts = [(0.0, FINE), (0.09, 2.0 * FINE), (0.15, COARSE)]
    if np.isfinite(step) and step > 0.2:
        starts += [
            (step - 2.0 * COARSE, FINE),
            (step + 0.15, 2.0 * FINE),
            (step + 0.4, COARSE),
        ]
    starts.append((end, COARSE))
    parts = [
        np.arange(a, b - 0.5 * h, h)
        for (a, h), (b, _) in zip(starts[:-1], starts[1:], strict=True)
        if b > a
    ]
    return np.concatenate(parts)[1:]


def uniform_positions(end: float) -> np.ndarray:
    """Nodes of a run whose slip changes all the time (waveforms) [m]."""
    return np.arange(2.0 * FINE, end, 2.0 * FINE)
