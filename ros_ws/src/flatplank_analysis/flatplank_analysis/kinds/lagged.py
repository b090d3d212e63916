# SPDX-License-Identifier: Apache-2.0
"""First-order relaxation of an input over travel."""

from __future__ import annotations

import numpy as np


def relaxed(values: np.ndarray, spacing: float, sigma: np.ndarray) -> np.ndarray:
    """u' of sigma du'/dx + u' = u on an even grid, exact for an input of straight pieces.

    values (n,), spacing [m], sigma (lanes,) [m]; returns (lanes, n), at rest at the first sample.
    """
    sigma = np.maximum(np.asarray(sigma, float), 1e-6)
    decay = np.exp(-spacing / sigma)
    mean = sigma / spacing * (1.0 - decay)
    out = np.empty((len(sigma), len(values)))
    out[:, 0] = values[0]
    for i in range(1, len(values)):
        before, now = values[i - 1], values[i]
        out[:, i] = now - mean * (now - before) + decay * (out[:, i - 1] - before)
    return out
