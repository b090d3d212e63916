# SPDX-License-Identifier: Apache-2.0
"""What a channel scatters while the plank stands, and in which steps it was recorded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flatplank_analysis.contact_patch.grid import quantum
from flatplank_data.table import MeasurementTable

STILL = 1e-5
"""[m] plank travel up to which nothing moves: at the start of a run a tire has tens of newtons"""
LEAST = 6
"""filtered samples until then at least"""


def at_rest(smooth: Sequence[Mapping[str, np.ndarray]], names: Sequence[str]) -> tuple[float, ...]:
    """Standard deviation of the filtered channels before anything moves; empty: no run stood."""
    squares = []
    for columns in smooth:
        moved = np.flatnonzero(columns["plank_position"] > STILL)
        # first values that were held backwards are no measurement
        held = np.all([np.diff(columns[n], prepend=np.nan) == 0.0 for n in names], axis=0)
        rows = np.flatnonzero(~held[: moved[0] if len(moved) else 0])
        if len(rows) < LEAST:
            continue
        squares.append([np.var(columns[n][rows], ddof=1) for n in names])
    return tuple(float(v) for v in np.sqrt(np.mean(squares, axis=0))) if squares else ()


def steps_of(tables: Sequence[MeasurementTable], names: Sequence[str]) -> tuple[float, ...]:
    """Step in which each channel was recorded, 0 where it lies on no lattice."""
    return tuple(max(quantum(t[n][np.isfinite(t[n])]) for t in tables[:3]) for n in names)
