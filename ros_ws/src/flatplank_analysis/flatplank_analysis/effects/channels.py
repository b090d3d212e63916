# SPDX-License-Identifier: Apache-2.0
"""Other measured channels, for crosstalk."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flatplank_analysis.tirebase.data import TireRuns


def other(data: TireRuns, channel: str, tared: np.ndarray) -> np.ndarray:
    """Another measured channel (lanes, runs, samples), minus its value at the start when tared."""
    values = data.signals.get(channel)
    if values is None:
        return np.zeros((1, *data.position.shape)) * tared
    return values - tared * values[:, :5].mean(axis=1, keepdims=True)
