# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares: steps, walls, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.identify import least_squares


def test_derivatives_stay_inside_of_the_bounds():
    """Central differences, one-sided at a wall."""
    x, low, high = np.array([0.0, 1.0, 0.5]), np.zeros(3), np.ones(3)
    seen = []

    def residuals(z):
        seen.append(z)
        return np.column_stack([z[:, 0] ** 2, z[:, 1] * z[:, 2]])

    jacobian = least_squares.linearise(residuals, x, low, high, np.array([1.0, 2.0, 0.1]))
    np.testing.assert_allclose(jacobian, [[0.0, 0.0, 0.0], [0.0, 0.5, 1.0]], atol=1e-3)
    np.testing.assert_allclose(seen[0][:3].diagonal() - x, [1e-4, 0.0, 5e-5])
    np.testing.assert_allclose(x - seen[0][3:].diagonal(), [0.0, 2e-4, 5e-5])


@pytest.mark.parametrize("start", [2.5, -2.5])
@pytest.mark.parametrize("turns", [1.0, -1.0])
def test_a_search_goes_on_in_both_directions(start, turns):
    """sinh: far away each step is about 1."""
    found = least_squares.solve(
        lambda sets: np.hstack([np.sinh(turns * sets), 0.1 * sets - 0.02]),
        np.array([start]), np.array([-9.0]), np.array([9.0]),
    )  # fmt: skip
    assert found.converged and abs(found.jacobian.T @ found.residual)[0] < 1e-6
    assert found.x[0] == pytest.approx(0.002 / 1.01, rel=1e-3)
    assert 3 <= found.iterations < 20


def test_the_end_of_a_search_and_what_it_costs():
    """A straight line takes two steps; a search that may not take another says so."""
    calls = []

    def line(sets):
        calls.append(len(sets))
        return sets @ np.array([[1.0, 2.0, 3.0], [1.0, 0.0, -1.0]]) - [1.0, 5.0, 2.0]

    low, high = np.full(2, -50.0), np.full(2, 50.0)
    wanted = np.linalg.lstsq(np.array([[1.0, 1.0], [2.0, 0.0], [3.0, -1.0]]), [1.0, 5.0, 2.0])[0]
    found = least_squares.solve(line, np.array([20.0, -30.0]), low, high, tolerance=1e-13)
    assert found.converged and found.x == pytest.approx(wanted, abs=1e-6)
    assert calls[:2] == [4, 1] and found.iterations <= 3
    assert not found.at_bound.any() and found.cost == pytest.approx(
        np.sum(line(wanted[None]) ** 2)
    )
    stopped = least_squares.solve(line, np.array([20.0, -30.0]), low, high, iterations=1)
    assert not stopped.converged and stopped.iterations == 1
    there = least_squares.solve(line, wanted, low, high)
    assert there.converged and there.x == pytest.approx(wanted, abs=1e-9)
    outside = least_squares.solve(line, np.array([90.0, 0.0]), low, np.array([1.0, 50.0]))
    assert outside.at_upper.tolist() == [True, False] and outside.x[0] == 1.0
    edge = least_squares.solve(line, np.array([2.0, 3.0]), np.array([-50.0, 2.0]), high)
    assert edge.at_lower.tolist() == [False, True] and edge.x[1] == 2.0


def test_a_trial_that_is_not_finite_is_not_taken():
    """A wall of NaN beside the minimum."""

    def wall(sets):
        return np.where(sets > 1.2, np.nan, np.exp(sets) - 2.0)

    found = least_squares.solve(wall, np.array([-3.0]), np.array([-9.0]), np.array([9.0]))
    assert found.x[0] == pytest.approx(np.log(2.0), rel=1e-6)
