# SPDX-License-Identifier: Apache-2.0
"""Runs that ended early: all runs with a step at one place are computed up to the shortest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flatplank_data.table import MeasurementTable

SHARE = 0.8
"""of the usual travel; a shorter run would cost the others more than it brings"""


def ended_early(tables: list[MeasurementTable]) -> Iterator[tuple[int, float, float]]:
    """Index, travel and usual travel [m] of runs that are much shorter than others of their kind.

    Kind: the same step position and waveform. Usual: the median.
    """
    travel = np.array([_travel(t) for t in tables])
    kinds = [(repr(t.info.step_position), repr(t.info.waveform)) for t in tables]
    for kind in dict.fromkeys(kinds):
        rows = [i for i, k in enumerate(kinds) if k == kind]
        usual = float(np.median(travel[rows]))
        for i in rows:
            if travel[i] < SHARE * usual:
                yield i, float(travel[i]), usual


def _travel(table: MeasurementTable) -> float:
    position = table["plank_position"]
    return float(np.nanmax(position) - np.nanmin(position))
