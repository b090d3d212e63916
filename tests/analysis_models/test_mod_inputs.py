# SPDX-License-Identifier: Apache-2.0
"""Inputs of the transient models."""

from __future__ import annotations

import math

import numpy as np

from flatplank_analysis.models.base import column, slip_inputs, stack_runs


def test_inputs_say_what_moved():
    run = slip_inputs(np.array([0.0, 0.1, 0.3]), 0.02, 3000.0, alpha=0.1)
    np.testing.assert_allclose(run.travel[0], [0.0, 0.1, 0.2])
    np.testing.assert_allclose(run.slip_x[0], [0.0, 0.002, 0.004])
    np.testing.assert_allclose(run.slip_y[0], np.tan(0.1) * run.travel[0])
    short = slip_inputs(np.array([0.0, 0.1]), 0.02, 4000.0, start_fy=3.0)
    both = stack_runs([run, short])
    assert both.travel[1].tolist() == [0.0, 0.1, 0.0] and both.fz[1].tolist() == [4000.0] * 3
    assert both.start_fy.tolist() == [0.0, 3.0] and both.shape == (2, 3)
    assert column(np.ones((4, 2)), 1).shape == (4, 1)
    assert column(np.ones((4, 2, 3)), 1).shape == (4, 3)


def test_inputs_of_one_run_are_rows():
    x = np.array([0.5, 0.4, 0.4, 0.7])
    given = {"alpha": 0.2, "gamma": 0.03, "pressure": 2e5, "start_fx": 4.0, "start_fy": -5.0}
    ahead = slip_inputs(x, np.array([9.0, 0.1, 0.2, 0.3]), 3e3, **given)
    np.testing.assert_allclose(ahead.travel, [[0.0, 0.1, 0.0, 0.3]])
    np.testing.assert_allclose(ahead.slip_x, [[0.0, 0.01, 0.0, 0.09]])
    np.testing.assert_allclose(ahead.slip_y, math.tan(0.2) * ahead.travel)
    assert ahead.shape == (1, 4)
    for name, value in (("fz", 3e3), ("alpha", 0.2), ("gamma", 0.03), ("pressure", 2e5)):
        assert getattr(ahead, name).tolist() == [[value] * 4], name
    assert (ahead.start_fx.tolist(), ahead.start_fy.tolist()) == ([4.0], [-5.0])


def test_a_parameter_of_all_runs_and_one_of_each():
    assert column(np.array([[1.0, 2.0], [3.0, 4.0]]), 1).tolist() == [[2.0], [4.0]]
    assert column(np.arange(12.0).reshape(2, 2, 3), 1).tolist() == [[3, 4, 5], [9, 10, 11]]
