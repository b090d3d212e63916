# SPDX-License-Identifier: Apache-2.0
"""Drawn numbers, and the groups of the runs of `shapes.measured`."""

from __future__ import annotations

import numpy as np
from shapes import CONDITIONS, REPEATS

RUNS = CONDITIONS * REPEATS
GROUPS = [np.arange(REPEATS * c, REPEATS * (c + 1)) for c in range(CONDITIONS)]
SPARE = CONDITIONS * (REPEATS - 1)


def numbers(seed: int, *size: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(size)


def without(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n,) less what least squares makes of them by columns (n, k)."""
    return values - columns @ np.linalg.lstsq(columns, values)[0]
