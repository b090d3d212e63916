# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness and steady curve of one condition: cells, weights, equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from idn_runs import numbers

from flatplank_analysis.identify import carcass_problem
from flatplank_analysis.identify import carcass_problem as carcass_joint
from flatplank_validation.fits.campaigns import Truth, simulate_runs


@pytest.mark.parametrize("begin", [0.7, 1.4])
def test_stiffness_and_curve_are_solved_from_both_sides(begin):
    still = Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0, carcass_scatter=0.0)
    runs = simulate_runs(still, np.random.default_rng(0))
    problem = carcass_problem.carcass_problem(runs)
    state, done = carcass_joint.solve_jointly(problem, begin * still.c_cx, (2e4, 5e6))
    assert done and state.c_cx == pytest.approx(still.c_cx, rel=5e-3)
    assert np.abs(state.scores()[1:]).max() < 1.0
    # some of the runs alone say the same, to first order
    assert state.stiffness_of(problem.level < 3) == pytest.approx(still.c_cx, rel=0.02)
    # and each error's pull on c_cx is what the equations say
    gradient = np.zeros(len(state.matrix))
    gradient[0] = 1.0
    pull = state.sensitivity(gradient)
    moved = replace(state, error=state.error + 1e-3 * numbers(12, *pull.shape))
    change = -np.linalg.solve(state.matrix, moved.scores() - state.scores())[0]
    assert change == pytest.approx(np.sum(pull * (moved.error - state.error)), rel=1e-6)


@pytest.fixture(scope="module")
def away():
    """Equations at a stiffness and a curve that are off by a few percent."""
    still = Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0, carcass_scatter=0.0)
    slips = (-0.05, -0.02, 0.0, 0.02, 0.05)
    runs = simulate_runs(still, np.random.default_rng(0), slips=slips)
    problem = carcass_problem.carcass_problem(runs)
    return still.c_cx, carcass_joint.joint_state(problem, 1.03 * still.c_cx)


def test_equations_are_those_of_weighted_errors(away):
    """c_cx: weighted squares of all runs; a level: mean error of its own settled part."""
    _, state = away
    p, h = state.problem, 1e-3
    whole = np.concatenate([[state.c_cx], p.curve.force])

    def error(at):
        return p.simulate(at[:1, None], at[None, 1:])[0] - p.measured

    np.testing.assert_allclose(state.error, error(whole), atol=1e-9)
    slopes = []
    for i, value in enumerate(whole):
        step = np.zeros_like(whole)
        step[i] = h * max(abs(value), 100.0)
        slopes.append((error(whole + step) - error(whole - step)) / (2.0 * step[i]))
    scores = [np.sum(p.weight**2 * slopes[0] * state.error)]
    for k in range(len(p.curve.force)):
        own = p.level == k
        scores.append(np.sum((p.settled * slopes[1 + k] * state.error)[own]))
    np.testing.assert_allclose(state.scores(), scores, rtol=0.01, atol=1e-3 * np.abs(scores).max())
    top = [np.sum(p.weight**2 * slopes[0] * s) for s in slopes]
    np.testing.assert_allclose(state.matrix[0], top, rtol=0.02, atol=1e-3 * np.abs(top).max())


@pytest.mark.parametrize("part", [slice(None), slice(0, 6), slice(3, None)])
def test_stiffness_of_some_runs_is_one_newton_step_of_theirs(away, part):
    truth, state = away
    own = np.zeros(len(state.problem.level), bool)
    own[part] = True
    levels = np.unique(state.problem.level[own])
    rows, left = np.zeros((1 + len(levels), 1 + len(levels))), np.zeros(1 + len(levels))
    free = [0, *(1 + levels)]
    for i in np.flatnonzero(own):
        place = 1 + int(np.searchsorted(levels, state.problem.level[i]))
        for kind, row in ((0, 0), (1, place)):
            rows[row] += state.every[kind, i, free]
            left[row] += state.rows[kind, i] @ state.error[i]
    wanted = state.c_cx - np.linalg.solve(rows, left)[0]
    assert state.stiffness_of(own) == pytest.approx(wanted, rel=1e-9)
    assert abs(wanted - truth) < 0.5 * abs(state.c_cx - truth)
