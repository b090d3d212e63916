# SPDX-License-Identifier: Apache-2.0
"""Carcass stiffness and steady curve of one condition: cells, weights, equations."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from idn_runs import X, numbers, run

from flatplank_analysis.identify import carcass_problem
from flatplank_analysis.identify import carcass_problem as carcass_joint
from flatplank_analysis.identify.noise import ARNoise
from flatplank_validation.fits.campaigns import Truth, simulate_runs


def test_cells_of_a_carcass_fit_grow_to_their_limits():
    edges = carcass_problem._cells(2500, 0.001)
    width = np.diff(edges)
    assert edges[0] == 0 and 2480 <= edges[-1] <= 2500
    assert width[0] == 1 and width.max() == 20
    inner = edges[1:] < 800
    assert width[inner].max() == 8 and np.all(np.diff(width[width < 8][:8]) >= -1)
    np.testing.assert_allclose(
        np.cumsum(0.001 * 1.06 ** np.arange(20))[-1], 1e-3 * edges[20], atol=2e-3
    )
    sums = carcass_problem._cell_sums(np.arange(10.0), np.array([0, 2, 5, 9]))
    assert sums.tolist() == [1.0, 9.0, 26.0]


def test_data_of_a_carcass_fit():
    """Means and summed weights of cells; 100 in the transient part, 1 after it."""
    runs = [run(0.02), run(0.02, distance=X[X < 1.6])]
    fits = [r.linear() for r in runs]
    x, force, weight, settled = carcass_problem._measured(runs, fits)
    np.testing.assert_allclose(force[0], np.interp(x, X, runs[0].fx), atol=2.0)
    end = fits[0].transient_end
    early, late = x < end - 0.05, x > end + 0.05
    assert np.sum(weight[0, early] ** 2) == pytest.approx(100.0 * 1e3 * (end - 0.05), rel=0.03)
    assert np.sum(weight[0, late] ** 2) == pytest.approx(1e3 * (X[-1] - end - 0.05), rel=0.03)
    assert np.sum(weight[0] ** 2) == pytest.approx(1e3 * (99.0 * end + X[-1]), rel=0.01)
    assert not weight[1, x > 1.61].any() and not force[1, x > 1.61].any()
    # settled from the end of the transient part, or from 70 % of the record on
    first = x[np.flatnonzero(settled[0])[0]]
    assert first == pytest.approx(min(end, 0.7 * X[-1]), abs=0.03)
    assert x[np.flatnonzero(settled[1])[0]] == pytest.approx(0.7 * 1.6, abs=0.03)
    assert settled[0].sum() == pytest.approx(1e3 * (X[-1] - min(end, 0.7 * X[-1])), rel=0.02)


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


def test_noise_of_a_quantity_is_summed_over_cells():
    """A mean over n samples of white noise: s/sqrt(n), whatever the cells."""
    centres = np.cumsum(np.linspace(0.002, 0.02, 150))
    one = run(distance=np.arange(0.0005, centres[-1], 0.001))
    count = len(one.distance)
    cells = np.gradient(centres)
    state = SimpleNamespace(problem=SimpleNamespace(distance=centres))
    sensitivity = (cells / 0.001 / count)[None]
    found = carcass_joint.noise_error([one], state, sensitivity, ARNoise((), 2.0, 9))
    assert found == pytest.approx(2.0 / np.sqrt(count), rel=0.02)
    two = carcass_joint.noise_error([one] * 2, state, np.vstack([sensitivity] * 2),
                                    ARNoise((), 2.0, 9))  # fmt: skip
    assert two == pytest.approx(found * 2.0**0.5)


def test_noise_comes_from_what_differs_between_repeats():
    """What all repeats of a level share is no noise; without repeats the residual is."""
    x = X
    shared, noise = 40.0 * np.sin(5.0 * x), 2.0 * numbers(20, 6, len(x))
    runs = [run(s, distance=x, name=f"{s}{i}") for s in (0.02, 0.05) for i in range(3)]
    measured = np.array([r.fx + shared + e for r, e in zip(runs, noise, strict=True)])
    runs = [replace(r, fx=row) for r, row in zip(runs, measured, strict=True)]
    runs[4] = replace(runs[4], distance=x[:1000], fx=runs[4].fx[:1000])
    problem = SimpleNamespace(measured=measured, distance=x)
    state = SimpleNamespace(problem=problem, error=-shared - noise)
    found = carcass_joint.repeat_noise(runs, state)
    assert found.std == pytest.approx(2.0, rel=0.05) and found.samples == 6 * 900
    alone = SimpleNamespace(problem=SimpleNamespace(measured=measured[:1], distance=x),
                            error=state.error[:1])  # fmt: skip
    residual = carcass_joint.repeat_noise(runs[:1], alone)
    assert 10.0 < residual.std < 20.0 and residual.samples == len(x) - 100


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


@pytest.mark.parametrize(("pull", "ends"), [(-9e9, [2.6e5, 3.2e5]), (9e9, [1.4e5, 0.9e5])])
def test_newton_steps_are_short_and_stay_in_the_bounds(away, monkeypatch, pull, ends):
    """At most 0.3 of the stiffness that the search began with."""
    problem, seen = away[1].problem, []
    count = 1 + len(problem.curve.force)

    def state(_, c_cx):
        seen.append(c_cx)
        scores = np.append(pull, np.zeros(count - 1))
        return SimpleNamespace(c_cx=c_cx, matrix=np.eye(count), scores=lambda: scores)

    monkeypatch.setattr(carcass_joint, "joint_state", state)
    last, done = carcass_joint.solve_jointly(problem, 2e5, (0.9e5, 3.2e5))
    assert seen[:3] == pytest.approx([2e5, *ends]) and done and last.c_cx == seen[-1]
    seen.clear()
    _, done = carcass_joint.solve_jointly(problem, 2e5, (-1e9, 1e9))
    assert not done and len(seen) == 13
