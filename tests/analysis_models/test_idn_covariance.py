# SPDX-License-Identifier: Apache-2.0
"""Covariance of runs that scatter: means and straight lines know it without a fit."""

from __future__ import annotations

import numpy as np
import pytest
from idn_runs import numbers

from flatplank_analysis.identify.noise import PropagatedErrors, run_covariance


def test_covariance_of_a_mean_is_that_of_the_means_of_runs():
    """CR2: unbiased where all runs are alike, with one degree of freedom less than runs."""
    runs, each = 7, 5
    y = numbers(2, runs, 1) + 0.1 * numbers(3, runs, each)
    jac = np.ones((runs * each, 1))
    index = np.repeat(np.arange(runs), each)
    found = run_covariance(jac, (y - y.mean()).ravel(), index)
    own = y.mean(axis=1)
    assert found.matrix[0, 0] == pytest.approx(own.var(ddof=1) / runs)
    assert found.dof[0] == pytest.approx(runs - 1.0)
    np.testing.assert_allclose(
        found.run_contributions[:, 0] ** 2 @ np.ones(runs), found.matrix[0, 0]
    )
    assert found.correlation == pytest.approx(np.eye(1))
    # a prior that knows as much as the data halves the pull and has an error of its own
    prior = np.array([[float(runs * each)]])
    halved = run_covariance(jac, (y - y.mean()).ravel(), index, prior)
    pulls = (own - y.mean()) * each / (2.0 * runs * each) / np.sqrt(1.0 - 0.5 / runs)
    assert halved.matrix[0, 0] == pytest.approx(pulls @ pulls + 0.25 / (runs * each))
    # what an earlier fit brought to a row comes with its run
    propagated = PropagatedErrors(np.array([0, 9]), np.ones((2, runs * each)) * [[0.3], [2.0]])
    both = run_covariance(jac, (y - y.mean()).ravel(), index, None, propagated)
    pulls = (own - y.mean()) / runs / np.sqrt(1.0 - 1.0 / runs)
    pulls[0] -= 0.3
    assert both.matrix[0, 0] == pytest.approx(pulls @ pulls + 2.0**2)
    assert both.runs.tolist() == [*range(runs), 9]


def test_two_parameters_are_as_correlated_as_their_errors():
    index = np.repeat(np.arange(4000), 2)
    jac = np.column_stack([np.ones(8000), np.tile([0.0, 1.0], 4000)])
    noise = numbers(4, 8000)
    noise -= jac @ np.linalg.lstsq(jac, noise, rcond=None)[0]
    found = run_covariance(jac, noise, index)
    np.testing.assert_allclose(found.matrix, np.linalg.inv(jac.T @ jac), rtol=0.1)
    assert found.correlation[0, 1] == pytest.approx(-(0.5**0.5), abs=0.05)
    np.testing.assert_allclose(found.dof, 3998.0)
    # a direction that the rows do not have stays out; a run that is alone in one tells nothing
    flat = run_covariance(np.column_stack([jac[:, 0], 0.0 * jac[:, 0]]), noise, index)
    assert flat.std_error[1] == 0.0 and flat.std_error[0] > 0.0


def test_a_direction_that_only_rounding_tells_stays_out():
    """Two columns alike to 1e-9: their sum has an error, their difference none."""
    runs, each = 12, 6
    index = np.repeat(np.arange(runs), each)
    one = 300.0 * (1.0 + np.arange(runs * each) % 3)
    jac = np.column_stack([one, one * (1.0 + 1e-9 * numbers(30, runs * each))])
    noise = numbers(31, runs * each)
    found, alone = run_covariance(jac, noise, index), run_covariance(jac[:, :1], noise, index)
    np.testing.assert_allclose(found.std_error, 0.5 * alone.std_error[0], rtol=1e-6)
    assert found.correlation[0, 1] == pytest.approx(1.0)
    # degrees of freedom: runs less one direction; an uneven information leaves fewer
    np.testing.assert_allclose(found.dof, runs - 1.0)
    share = np.repeat([1.0, 3.0], [6, 6])
    uneven = run_covariance(jac[:, :1] * np.repeat(share, each)[:, None], noise, index)
    effective = np.sum(share**2) ** 2 / np.sum(share**4)
    assert uneven.dof[0] == pytest.approx(effective * 11.0 / 12.0)


def test_a_run_that_carries_a_direction_alone_is_freed_up_to_a_limit():
    """A leverage of 1 counts as 0.98."""
    jac, residual = np.eye(2), np.array([0.3, 0.7])
    found = run_covariance(jac, residual, np.array([0, 1]))
    np.testing.assert_allclose(found.std_error, residual / np.sqrt(1.0 - 0.98))
    np.testing.assert_allclose(found.dof, 1.0)
