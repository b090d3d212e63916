# SPDX-License-Identifier: Apache-2.0
"""Even grids over distance, so that a noise model means the same in every run."""

from __future__ import annotations

import numpy as np

from flatplank_data.errors import FlatplankError

SPACING = 0.002
"""Grid of the fits [m]: fine against every relaxation length, coarse against the filter."""


def bin_means(
    distance: np.ndarray, columns: np.ndarray, spacing: float = SPACING
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
    # A cell's mean belongs to the mean position of its samples, not to the cell's centre.
    places = np.bincount(cell - first, weights=x, minlength=count)[full] / number[full]
    flat = np.atleast_2d(values)
    means = np.empty((len(flat), count))
    for row, out in zip(flat, means, strict=True):
        sums = np.bincount(cell - first, weights=row, minlength=count)[full]
        out[:] = np.interp(centres, places, sums / number[full])
    return centres, means.reshape(*values.shape[:-1], count)
