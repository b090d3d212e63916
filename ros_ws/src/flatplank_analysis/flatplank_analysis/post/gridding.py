# SPDX-License-Identifier: Apache-2.0
"""Signals over road displacement: one even grid for all runs, mean and scatter of repeats."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SPACING = 1e-4
"""thesis 6.2 [m]"""
GRID = np.round(np.arange(41001) * SPACING, 10)
"""0 m to 4.1 m of road displacement, thesis 6.2 [m]"""


@dataclass(frozen=True)
class Gridded:
    """Columns over road displacement; NaN where a run has not been. `position` [m], shape (n,)."""

    position: np.ndarray
    columns: Mapping[str, np.ndarray]
    runs: int = 1
    """how many runs this is the mean of"""

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self.columns[name]
        except KeyError:
            raise FlatplankError(
                f"no column '{name}'", "resampled run", f"has {', '.join(self.columns)}"
            ) from None

    def map(
        self, function: Callable[[np.ndarray], np.ndarray], names: Iterable[str] | None = None
    ) -> Gridded:
        """The same with `function(values)` applied to columns (all, or `names`)."""
        chosen = set(self.columns if names is None else names)
        columns = {k: function(v) if k in chosen else v for k, v in self.columns.items()}
        return Gridded(self.position, columns, self.runs)


def on_grid(
    table: MeasurementTable,
    names: Sequence[str] | None = None,
    grid: np.ndarray = GRID,
) -> Gridded:
    """Columns of a run interpolated over road displacement.

    Where the plank stands still or its encoder repeats a count, the last sample counts.
    """
    travel = np.maximum.accumulate(table["plank_position"])
    last = np.append(np.diff(travel) > 0.0, True)
    x = travel[last]
    names = [n for n in (names or table.columns) if n != "plank_position" and table.has(n)]
    if x.size < 2:
        raise FlatplankError("zero speed", table.info.file, "the plank must move")
    columns = {n: np.interp(grid, x, table[n][last], left=np.nan, right=np.nan) for n in names}
    return Gridded(grid, columns)


def mean_of(runs: Sequence[Gridded]) -> Gridded:
    """Mean of runs, such as those from three start angles; where any has not been it is NaN."""
    if not runs:
        raise FlatplankError("no runs to average", "mean of starts", "give at least one")
    names = [n for n in runs[0].columns if all(n in run.columns for run in runs)]
    columns = {n: np.mean([run.columns[n] for run in runs], axis=0) for n in names}
    return Gridded(runs[0].position, columns, sum(run.runs for run in runs))


def mean_of_starts(runs: Sequence[Gridded], starts: Sequence[int]) -> Gridded:
    """Mean of the start angles, each the mean of its runs (section 6.2)."""
    groups = [[r for r, s in zip(runs, starts, strict=True) if s == one] for one in set(starts)]
    return replace(mean_of([mean_of(group) for group in groups]), runs=len(runs))


def repeat_std(runs: Sequence[Gridded], name: str = "fx") -> np.ndarray:
    """Standard deviation over repeats at every position (figure 6.22), shape (n,)."""
    if len(runs) < 2:
        raise FlatplankError("one run has no scatter", "repeatability", "give two repeats or more")
    return np.std([run[name] for run in runs], axis=0, ddof=1)
