# SPDX-License-Identifier: Apache-2.0
"""The descent in a valley that bends, at walls, and with a Jacobian that is out of date."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from flatplank_analysis.discovery.descent import (
    Problem,
    bounded_step,
    descend,
)

WIDE = np.full(2, 10.0)


def _bent(sharp: float, lower=-WIDE, upper=WIDE) -> tuple[Problem, list[int]]:
    """Rosenbrock's valley as residuals, its bottom at (1, 1); and how many Jacobians were made."""
    asked = [0]

    def of(z: np.ndarray) -> np.ndarray:
        return np.array([sharp * (z[1] - z[0] ** 2), z[0]]).reshape(1, 1, 2)

    def predict(points: list[np.ndarray]) -> np.ndarray:
        return np.array([of(z) for z in points])

    def jacobian(z: np.ndarray, _predicted: np.ndarray) -> np.ndarray:
        asked[0] += 1
        return np.array([[-2.0 * sharp * z[0], 1.0], [sharp, 0.0]]).reshape(2, 1, 1, 2)

    nothing = np.zeros(2)
    problem = Problem(
        np.array([0.0, 1.0]).reshape(1, 1, 2), predict, jacobian, lambda v: v,
        lambda _e: 1e-9, lower, upper, nothing, nothing,
    )  # fmt: skip
    return problem, asked


@pytest.mark.parametrize("sharp", [3.0, 10.0, 30.0])
def test_a_bent_valley_is_followed_to_its_bottom(sharp):
    problem, asked = _bent(sharp)
    end = descend(problem, np.array([-1.2, 1.0]), steps=60, jacobians=60)
    np.testing.assert_allclose(end.point.z, [1.0, 1.0], atol=1e-4)
    assert asked[0] <= 30


def test_the_bottom_beyond_a_wall_is_found_at_the_wall():
    problem, _ = _bent(10.0, upper=np.array([0.5, 10.0]))
    end = descend(problem, np.array([-1.2, 1.0]), steps=60, jacobians=60)
    np.testing.assert_allclose(end.point.z, [0.5, 0.25], atol=1e-4)


def test_a_jacobian_that_is_out_of_date_is_made_anew():
    problem, asked = _bent(10.0)
    wrong = -problem.jacobian(np.array([-1.2, 1.0]), np.zeros(0))
    end = descend(problem, np.array([-1.2, 1.0]), wrong, steps=60, jacobians=60)
    np.testing.assert_allclose(end.point.z, [1.0, 1.0], atol=1e-4)
    assert asked[0] > 1


@pytest.mark.parametrize("strength", [(0.0, 0.0), (2.0, 0.5), (0.0, 30.0)])
def test_a_linear_problem_takes_one_step(strength):
    """The start and the end are predicted, nothing else; and one Jacobian is made. Priors pull at
    the numbers as further rows would."""
    a, goal, asked = np.array([[1.0, 2.0, 3.0], [0.0, 1.0, -1.0]]), np.array([1.0, 3.0, 5.0]), []

    def predict(points: list[np.ndarray]) -> np.ndarray:
        asked.append(len(points))
        return np.array([z @ a for z in points]).reshape(-1, 1, 1, 3)

    def jacobian(_z: np.ndarray, _predicted: np.ndarray) -> np.ndarray:
        asked.append(0)
        return a.reshape(2, 1, 1, 3)

    centre = np.array([3.0, -1.0])
    problem = Problem(
        goal.reshape(1, 1, 3), predict, jacobian, lambda v: v, lambda _e: 1e-9, -WIDE, WIDE,
        centre, np.array(strength),
    )  # fmt: skip
    end = descend(problem, np.array([4.0, -4.0]))
    pull = np.diag(np.sqrt(strength))
    rows, goals = np.concatenate([a.T, pull]), np.concatenate([goal, pull @ centre])
    known = np.linalg.lstsq(rows, goals)[0]
    np.testing.assert_allclose(end.point.z, known, atol=1e-5)
    assert end.point.energy == pytest.approx(np.sum((rows @ known - goals) ** 2))
    assert asked == [1, 0, 1] and end.steps == 1


@pytest.mark.parametrize("unit", [1e-3, 1e3])
@pytest.mark.parametrize("start", [(-1.2, 1.0), (4.0, -3.0)])
def test_the_way_down_does_not_depend_on_the_unit_of_the_error(unit, start):
    ways = []
    for u in (1.0, unit):
        problem, asked = _bent(10.0)
        problem = replace(
            problem, metric=lambda v, u=u: u * v, enough=lambda _e, u=u: 1e-9 * u * u
        )
        end = descend(problem, np.array(start), steps=60, jacobians=60)
        ways.append((end.steps, asked[0], end.fresh, *(round(float(z), 6) for z in end.point.z)))
    assert ways[0] == ways[1]


def test_a_step_that_gains_more_than_was_said_is_not_the_last():
    """(1 - z)^2 + (6 - 5 z^2)^2 from 0, where the second part has no slope."""

    def predict(points: list[np.ndarray]) -> np.ndarray:
        return np.array([(z[0], 5.0 * z[0] ** 2) for z in points]).reshape(-1, 1, 1, 2)

    problem = Problem(
        np.array([[[1.0, 6.0]]]), predict,
        lambda z, _p: np.array([1.0, 10.0 * z[0]]).reshape(1, 1, 1, 2), lambda v: v,
        lambda _e: 1e-9, -WIDE[:1], WIDE[:1], np.zeros(1), np.zeros(1),
    )  # fmt: skip
    (z,) = descend(problem, np.zeros(1)).point.z
    assert -2.0 * (1.0 - z) - 20.0 * z * (6.0 - 5.0 * z**2) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("seed", range(40))
def test_a_bounded_step_is_the_best_one_in_its_box(seed):
    """Against a solver that is known to be right, many walls in the way."""
    rng = np.random.default_rng(seed)
    a = rng.standard_normal((30, 12)) @ np.diag(np.geomspace(1.0, 1e-3, 12))
    goal = a @ rng.standard_normal(12) * 5.0 + rng.standard_normal(30)
    lower, upper = -rng.uniform(0.0, 2.0, 12), rng.uniform(0.0, 2.0, 12)
    known = lsq_linear(a, goal, (lower, upper), method="bvls", tol=1e-14)
    found = bounded_step(a.T @ a, a.T @ goal, lower, upper, 0.0)
    assert np.all((found >= lower - 1e-12) & (found <= upper + 1e-12))
    assert np.sum((a @ found - goal) ** 2) <= np.sum((a @ known.x - goal) ** 2) * (1.0 + 1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_a_step_that_is_pushed_to_one_side_is_the_best_one_in_its_box(size, sign):
    """All columns and the goal are positive, so that every slope has one sign."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        a, goal = rng.uniform(0.0, 1.0, (20, size)), sign * rng.uniform(0.0, 3.0, 20)
        lower, upper = -rng.uniform(0.0, 1.0, size), rng.uniform(0.0, 1.0, size)
        known = lsq_linear(a, goal, (lower, upper), method="bvls", tol=1e-14).x
        found = bounded_step(a.T @ a, a.T @ goal, lower, upper, 0.0)
        np.testing.assert_allclose(found, known, atol=1e-5)
