# SPDX-License-Identifier: Apache-2.0
"""The fit of a carcass: what it refuses, when it has converged, on which bound it rests."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from idn_runs import X, run

from flatplank_analysis.identify import carcass, carcass_problem
from flatplank_analysis.models.base import TOYO
from flatplank_data.errors import FlatplankError

RUNS = [run(k, name=f"{k}") for k in (-0.02, 0.0, 0.02)]


def fit(monkeypatch, c_cx=3e5, found=True, done=True, **options):
    """What the report is given."""
    given = {}

    def solved(problem, begin, bounds):
        given.update(problem=problem, begin=begin, bounds=bounds)
        return SimpleNamespace(c_cx=c_cx), done

    at = SimpleNamespace(x=np.array([2.5e5]), converged=found)
    monkeypatch.setattr(carcass, "search_carcass", lambda _, bounds: at)
    monkeypatch.setattr(carcass, "solve_jointly", solved)
    monkeypatch.setattr(carcass, "report", lambda *words: words)
    runs, fits, state, edge, converged = carcass.fit_carcass(RUNS, **options)
    assert len(runs) == len(fits) == 3 and state.c_cx == c_cx
    return edge, converged, given


@pytest.mark.parametrize("found", [True, False])
@pytest.mark.parametrize("done", [True, False])
def test_both_searches_must_have_converged(monkeypatch, found, done):
    assert fit(monkeypatch, found=found, done=done)[1] is (found and done)


@pytest.mark.parametrize(
    ("c_cx", "edge"),
    [(1e5, "lower"), (1e5 + 0.09, "lower"), (1e5 + 0.2, ""), (4e5, "upper"), (4e5 - 0.5, "")],
)
def test_a_millionth_from_the_bound_is_on_it(monkeypatch, c_cx, edge):
    told, _, given = fit(monkeypatch, c_cx, bounds=(1e5, 4e5))
    assert told == edge and given["bounds"] == (1e5, 4e5)
    assert given["begin"] == 2.5e5


def test_every_start_angle_counts_once(monkeypatch):
    monkeypatch.setattr(carcass, "solve_jointly", lambda *_: (SimpleNamespace(c_cx=3e5), True))
    monkeypatch.setattr(carcass, "report", lambda runs, *_: runs)
    again = [*RUNS, replace(RUNS[2], start=2), replace(RUNS[2], start=2)]
    assert [r.start for r in carcass.fit_carcass(again)] == [1, 1, 1, 2]


def test_levels_of_one_condition_are_asked_for():
    for runs in (RUNS[:2], [*RUNS, replace(RUNS[0], operating_point="two")]):
        with pytest.raises(FlatplankError, match="three or more slip levels") as error:
            carcass.fit_carcass(runs)
        assert "one" in str(error.value)
    with pytest.raises(FlatplankError, match="add slip levels"):
        carcass.fit_carcass([])


def test_friction_is_the_largest_steady_force_over_the_load(monkeypatch):
    problem = fit(monkeypatch)[2]["problem"]
    assert problem.friction == pytest.approx(1800.0 / 3700.0, rel=2e-3)
    assert problem.tread_stiffness is None and problem.longitudinal is True
    braked = carcass_problem.carcass_problem([run(k) for k in (-0.03, 0.0, 0.02)])
    assert braked.friction == pytest.approx(2700.0 / 3700.0, rel=2e-3)
    assert problem.level.tolist() == [0, 1, 2] and problem.geometry is TOYO
    geometry = replace(TOYO, q_ra1=0.5)
    options = {"friction": 0.7, "tread_stiffness": 2e7, "longitudinal": False}
    problem = fit(monkeypatch, geometry=geometry, **options)[2]["problem"]
    assert {name: getattr(problem, name) for name in options} == options
    assert problem.geometry is geometry


def test_the_search_over_the_stiffness_sees_weighted_errors():
    problem = carcass_problem.carcass_problem(RUNS)
    sets = np.array([[2e5], [3e5]])
    rows = problem.residuals(sets)
    error = problem.simulate(sets, np.tile(problem.curve.force, (2, 1))) - problem.measured
    np.testing.assert_allclose(rows, (problem.weight * error).reshape(2, -1), atol=1e-6)
    found = carcass_problem.search_carcass(problem, (2e4, 5e6))
    assert (
        found.converged
        and found.cost < problem.residuals(found.x[None] * 1.01)[0].std() ** 2 * rows.shape[1]
    )
    assert found.x[0] == pytest.approx(9e4 / (0.4 - 0.0708), rel=0.1)
    assert X[-1] > problem.distance[-1]
