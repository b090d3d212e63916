# SPDX-License-Identifier: Apache-2.0
"""Even grids over distance."""

from __future__ import annotations

import numpy as np
from idn_runs import numbers

from flatplank_analysis.post import gridding as grid


def test_an_even_grid_stays_as_it_is():
    x = 0.002 * np.arange(50)
    values = numbers(1, 2, 50)
    centres, found = grid.bin_means(x, values)
    np.testing.assert_array_equal(centres, x)
    np.testing.assert_array_equal(found, values)


def test_cells_begin_at_the_step_and_gaps_are_filled():
    x = np.array([-0.0005, 0.0002, 0.0012, 0.0015, 0.0045, 0.0061, 0.0063, 0.0079, 0.009])
    values = np.where(x == 0.0012, np.nan, 10.0 * x)
    centres, found = grid.bin_means(x, values)
    np.testing.assert_allclose(centres, 0.002 * np.arange(-1, 5) + 0.001)
    # of a straight line every cell has its own value, the empty one between 2 and 4 mm, too
    np.testing.assert_allclose(found[1:-1], 10.0 * centres[1:-1])
    assert found.shape == centres.shape
