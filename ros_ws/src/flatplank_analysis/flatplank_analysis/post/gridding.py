# SPDX-License-Identifier: Apache-2.0
"""Signals over road displacement: cell averages, uniform grid, low-pass, mean and scatter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from flatplank_analysis.starts import mean_over_starts
from flatplank_data.errors import FlatplankError
from flatplank_data.machine import FAST
from flatplank_data.table import MeasurementTable

CELL = 0.002
"""Grid spacing of the fits [m]: fine relative to relaxation lengths, coarse for the filter."""


def bin_means(
    distance: np.ndarray, columns: np.ndarray, spacing: float = CELL
) -> tuple[np.ndarray, np.ndarray]:
    """Means of columns (..., n) in cells of `spacing` [m]; the step (distance 0) is a cell edge.

    Returns the cell centres (m,) and the means (..., m). Cells without a sample are interpolated.
    """
    x = np.asarray(distance, float)
    values = np.asarray(columns, float)
    good = np.isfinite(x) & np.all(np.isfinite(np.atleast_2d(values)), axis=0)
    if np.count_nonzero(good) < 8:
        raise FlatplankError(
            f"{np.count_nonzero(good)} usable samples are too few to fit", "", "give a whole run"
        )
    x, values = x[good], values[..., good]
    if np.all(np.abs(np.diff(x) - spacing) < 0.01 * spacing):
        return x, values
    cell = np.floor(x / spacing + 1e-9).astype(int)
    first, count = cell.min(), cell.max() - cell.min() + 1
    number = np.bincount(cell - first, minlength=count)
    full = number > 0
    centres = (np.arange(count) + first + 0.5) * spacing
    # a cell's mean belongs to the mean position of its samples, not to the cell's centre
    places = np.bincount(cell - first, weights=x, minlength=count)[full] / number[full]
    flat = np.atleast_2d(values)
    means = np.empty((len(flat), count))
    for row, out in zip(flat, means, strict=True):
        sums = np.bincount(cell - first, weights=row, minlength=count)[full]
        out[:] = np.interp(centres, places, sums / number[full])
    return centres, means.reshape(*values.shape[:-1], count)


CUTOFF_PER_METRE = 10.0 / FAST
"""Cut-off path frequency of the low-pass: 10 Hz at 0.03092 m/s, 323 1/m."""
ORDER = 2
"""order of the filter, which runs forward and backward; not stated in the thesis"""


def low_pass(
    values: np.ndarray, spacing: float = 1e-4, cutoff: float = CUTOFF_PER_METRE
) -> np.ndarray:
    """`values` on a uniform grid of `spacing` [m] without frequencies above `cutoff` [1/m].

    The cut-off is defined over distance: over time it would change with the plank speed. Leading
    and trailing NaN are kept.
    """
    out = np.array(values, dtype=np.float64)
    finite = np.flatnonzero(np.isfinite(out))
    nyquist = 0.5 / spacing
    if finite.size < 30 * ORDER or cutoff >= nyquist:
        return out
    span = slice(finite[0], finite[-1] + 1)
    sections = butter(ORDER, cutoff / nyquist, output="sos")
    out[span] = sosfiltfilt(sections, out[span])
    return out


SPACING = 1e-4
"""spacing of GRID, thesis 6.2 [m]"""
GRID = np.round(np.arange(41001) * SPACING, 10)
"""road displacement from 0 to 4.1 m, thesis 6.2 [m]"""


@dataclass(frozen=True)
class Gridded:
    """Columns over road displacement `position` [m], shape (n,); NaN outside a run's range."""

    position: np.ndarray
    columns: Mapping[str, np.ndarray]
    runs: int = 1
    """number of runs in the mean"""

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
        """A copy with `function(values)` applied to columns (all, or `names`)."""
        chosen = set(self.columns if names is None else names)
        columns = {k: function(v) if k in chosen else v for k, v in self.columns.items()}
        return Gridded(self.position, columns, self.runs)


def on_grid(table: MeasurementTable, names: Sequence[str]) -> Gridded:
    """Columns of a run interpolated over road displacement.

    Where the plank stands still or its encoder repeats a count, the last sample is used.
    """
    travel = np.maximum.accumulate(table["plank_position"])
    last = np.append(np.diff(travel) > 0.0, True)
    x = travel[last]
    names = [n for n in names if n != "plank_position" and table.has(n)]
    if x.size < 2:
        raise FlatplankError("zero speed", table.info.file, "the plank must move")
    columns = {n: np.interp(GRID, x, table[n][last], left=np.nan, right=np.nan) for n in names}
    return Gridded(GRID, columns)


def mean_of_starts(runs: Sequence[Gridded], starts: Sequence[int]) -> Gridded:
    """Mean of the start angles, each the mean of its runs (section 6.2); NaN where any run has no
    data."""
    if not runs:
        raise FlatplankError("no runs to average", "mean of starts", "give at least one")
    names = [n for n in runs[0].columns if all(n in run.columns for run in runs)]
    columns = {n: mean_over_starts([run.columns[n] for run in runs], starts) for n in names}
    return Gridded(runs[0].position, columns, len(runs))


def repeat_std(runs: Sequence[Gridded], name: str = "fx") -> np.ndarray:
    """Standard deviation over repeats at every position (figure 6.22), shape (n,)."""
    if len(runs) < 2:
        raise FlatplankError("one run has no scatter", "repeatability", "give two repeats or more")
    return np.std([run[name] for run in runs], axis=0, ddof=1)
