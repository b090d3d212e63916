# SPDX-License-Identifier: Apache-2.0
"""Steady quantities of tire and machine, a module for each kind of quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Value:
    """A quantity in SI with its standard error and the number of runs behind it."""

    value: float
    std_error: float = math.nan
    runs: int = 1
    note: str = ""


def mean_value(values: Sequence[float], note: str = "") -> Value:
    """Mean of runs; the standard error is that of the mean, NaN for a single run."""
    array = np.array([v for v in values if math.isfinite(v)])
    if not array.size:
        return Value(math.nan, math.nan, 0, note or "not measured")
    error = float(array.std(ddof=1) / math.sqrt(array.size)) if array.size > 1 else math.nan
    return Value(float(array.mean()), error, int(array.size), note)
