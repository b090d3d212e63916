# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares: steps, walls, derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.identify import (
    least_squares,
)


def test_steps_of_a_bounded_search():
    """Of the trials those that differ; a parameter at its wall that pulls outwards is held."""
    trials = np.array([[1.0, 0.0], [0.99, 0.0], [0.9, 0.0], [0.0, 0.5]])
    kept = least_squares._different(trials, np.zeros(2), np.ones(2))
    assert kept.tolist() == [0, 2, 3]
    x, low, high = np.array([0.0, 1.0, 0.5]), np.zeros(3), np.ones(3)
    jac, r = np.eye(3)[:, [0, 1, 2]], np.array([1.0, -1.0, 1.0])
    assert least_squares._free(x, r, jac, low, high).tolist() == [2]
    assert least_squares._free(x, -r, jac, low, high).tolist() == [0, 1, 2]
    assert least_squares._free(x, -0.5 * r, jac, low, high).tolist() == [0, 1, 2]
    assert least_squares._free(x, -r, jac * [1, 0, 1], low, high).tolist() == [0, 2]
    scale = np.ones(3)
    assert not least_squares._is_stationary(x, r, jac, low, high, scale)
    assert least_squares._is_stationary(x, r * [1, 1, 0], jac, low, high, scale)
    lanes, width = least_squares._stencil(x, low, high, np.array([1.0, 2.0, 0.1]))
    np.testing.assert_allclose(lanes[1:4].diagonal() - x, [1e-4, 0.0, 5e-5])
    np.testing.assert_allclose(x - lanes[4:].diagonal(), [0.0, 2e-4, 5e-5])
    np.testing.assert_allclose(width, [1e-4, 2e-4, 1e-4])
    residuals, jacobian = least_squares.linearise(
        lambda z: np.column_stack([z[:, 0] ** 2, z[:, 1] * z[:, 2]]), x, low, high, scale
    )
    np.testing.assert_allclose(residuals, [0.0, 0.5])
    np.testing.assert_allclose(jacobian, [[0.0, 0.0, 0.0], [0.0, 0.5, 1.0]], atol=1e-3)


@pytest.mark.parametrize("start", [2.5, -2.5])
@pytest.mark.parametrize("turns", [1.0, -1.0])
def test_a_search_goes_on_in_both_directions(start, turns):
    """sinh: far away each step is about 1."""
    found = least_squares.solve(
        lambda lanes: np.hstack([np.sinh(turns * lanes), 0.1 * lanes - 0.02]),
        np.array([start]), np.array([-9.0]), np.array([9.0]),
    )  # fmt: skip
    assert found.converged and abs(found.jacobian.T @ found.residual)[0] < 1e-6
    assert found.x[0] == pytest.approx(0.002 / 1.01, rel=1e-3)
    assert 3 <= found.iterations < 20


def test_the_end_of_a_search_and_what_it_costs():
    """A straight line takes two steps; a search that may not take another says so."""
    calls = []

    def line(lanes):
        calls.append(len(lanes))
        return lanes @ np.array([[1.0, 2.0, 3.0], [1.0, 0.0, -1.0]]) - [1.0, 5.0, 2.0]

    low, high = np.full(2, -50.0), np.full(2, 50.0)
    wanted = np.linalg.lstsq(np.array([[1.0, 1.0], [2.0, 0.0], [3.0, -1.0]]), [1.0, 5.0, 2.0])[0]
    found = least_squares.solve(line, np.array([20.0, -30.0]), low, high)
    assert found.converged and found.x == pytest.approx(wanted, abs=1e-6)
    assert calls[0] == 5 and len(calls) == 1 + found.iterations <= 5
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

    def wall(lanes):
        return np.where(lanes > 1.2, np.nan, np.exp(lanes) - 2.0)

    found = least_squares.solve(wall, np.array([-3.0]), np.array([-9.0]), np.array([9.0]))
    assert found.x[0] == pytest.approx(np.log(2.0), rel=1e-6)
    best, residual, ahead = least_squares._look(
        wall, np.array([[2.0], [0.5], [0.0]]), np.array([-9.0]), np.array([9.0]), np.ones(1)
    )
    assert best == 1 and residual[0] == pytest.approx(np.exp(0.5) - 2.0) and ahead is None
    # the boldest one wins a draw, and brings its derivatives
    best, _, ahead = least_squares._look(
        lambda lanes: np.abs(lanes), np.array([[1.0], [-1.0]]), np.array([-9.0]), np.array([9.0]),
        np.ones(1),
    )  # fmt: skip
    assert best == 0 and ahead == pytest.approx(np.array([[1.0]]))


def test_trials_are_damped_steps_inside_of_the_bounds():
    """(J'J + d diag J'J) step = -J'r in scaled variables."""
    rng = np.random.default_rng(5)
    jac, r, x = rng.normal(size=(6, 3)), rng.normal(size=6), np.array([1.0, 2.0, -1.0])
    scale, dampings = np.array([1.0, 3.0, 0.5]), np.array([1e-3, 1.0, 10.0])
    wide = np.full(3, 99.0)
    trials = least_squares._trials(x, r, jac, dampings, -wide, wide, scale)
    js = jac * scale
    for trial, d in zip(trials, dampings, strict=True):
        normal = js.T @ js
        step = np.linalg.solve(normal + d * np.diag(np.diag(normal)), -js.T @ r)
        np.testing.assert_allclose(trial, x + scale * step)
    held = least_squares._trials(x, r, jac, dampings, x, wide, scale)
    assert (held >= x).all() and (held <= wide).all()
    jac[:, 1] = 0.0  # without influence
    still = least_squares._trials(x, r, jac, dampings, -wide, wide, scale)
    assert (still[:, 1] == 2.0).all() and (still[:, 0] != 1.0).all()
