# SPDX-License-Identifier: Apache-2.0
"""The descent in a valley that bends, at walls, and with a Jacobian that is out of date."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from flatplank_analysis.discovery.descent import (
    PROBE,
    Problem,
    _broyden,
    _DampedSteps,
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


@pytest.mark.parametrize("sharp", [3.0, 10.0, 30.0])
def test_far_from_the_bottom_the_first_jacobian_is_updated(sharp):
    problem, asked = _bent(sharp)
    end = descend(problem, np.array([4.0, -3.0]), steps=60, jacobians=60)
    np.testing.assert_allclose(end.point.z, [1.0, 1.0], atol=1e-4)
    assert asked[0] <= 3 and end.steps <= 15


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


@pytest.mark.parametrize(("given", "made", "steps"), [(-1.0, 1, 2), (None, 2, 6)])
def test_a_slope_that_is_wrong_is_made_anew_or_damped(given, made, steps):
    """One that was given for this point and leads upwards is made anew at once; one that has just
    been made, a third of what it should be, is damped from 0.001 to 1. From there an update puts
    it right, and at the bottom it is asked for again."""
    problem = Problem(
        np.ones((1, 1, 1)), lambda points: np.array(points).reshape(-1, 1, 1, 1),
        lambda _z, _p: np.full((1, 1, 1, 1), asked.append(0) or slope), lambda v: v,
        lambda _e: 1e-9, -WIDE[:1], WIDE[:1], np.zeros(1), np.zeros(1),
    )  # fmt: skip
    asked, slope = [], 1.0 if given else 1.0 / 3.0
    columns = None if given is None else np.full((1, 1, 1, 1), given)
    end = descend(problem, np.zeros(1), columns)
    assert end.point.z == pytest.approx([1.0]) and (len(asked), end.steps) == (made, steps)


def test_an_updated_jacobian_reproduces_the_last_step_and_keeps_the_rest():
    draw = np.random.default_rng(3)
    columns, change = draw.standard_normal((4, 1, 2, 5)), draw.standard_normal((1, 2, 5))
    move, across = np.array([1.0, -2.0, 0.5, 0.0]), np.array([2.0, 1.0, 0.0, 3.0])
    new = _broyden(columns, move, change)
    np.testing.assert_allclose(np.tensordot(move, new, axes=1), change)
    old = np.tensordot(across, columns, axes=1)
    np.testing.assert_allclose(np.tensordot(across, new, axes=1), old)
    assert _broyden(columns, 1e-7 * move, change) is columns


@pytest.mark.parametrize(
    ("bend", "goal"), [(0.4, 0.3), (-0.4, 0.3), (0.4, -0.3), (1.0, 2.0), (2.5, 2.0)]
)
def test_a_step_is_corrected_by_half_of_its_second_derivative(bend, goal):
    """z + bend z^2 = goal, from 0: the step is `goal`, the correction - bend goal^2, never longer
    than the step, and left out beyond three times its length."""

    def predict(points: list[np.ndarray]) -> np.ndarray:
        return np.array([z + bend * z**2 for z in points]).reshape(-1, 1, 1, 1)

    nothing, wide = np.zeros(1), np.full(1, 9.0)
    problem = Problem(
        np.array([[[goal]]]), predict, lambda _z, _p: np.ones((1, 1, 1, 1)), lambda v: v,
        lambda _e: 1e-9, -wide, wide, nothing, nothing,
    )  # fmt: skip
    steps = _DampedSteps(problem, problem.points([nothing])[0], np.ones((1, 1, 1, 1)))
    probed = problem.points([np.array([PROBE * goal])])
    ends = steps.second_order([np.array([goal])], [1e-9], probed)
    if abs(bend * goal) > 3.0:
        assert ends == []
    else:
        ((point, damping),) = ends
        turn = np.clip(-bend * goal**2, -abs(goal), abs(goal))
        assert damping == 1e-9 and point.z[0] == pytest.approx(goal + turn, rel=1e-6)


@pytest.mark.parametrize(
    ("bend", "end"), [(5.0, [-5.0, 1.0]), (20.0, [-10.0, 1.0]), (40.0, None), (np.nan, None)]
)
def test_corrections_are_measured_by_what_they_change(bend, end):
    """z0 + bend z1^2 and 10 z1, from 0 to z1 = 1: the step changes the second by 10, and the
    correction of z0 the first by its bend. It is never larger, and left out at three times it."""

    def predict(points: list[np.ndarray]) -> np.ndarray:
        return np.array([(z[0] + bend * z[1] ** 2, 10.0 * z[1]) for z in points]).reshape(
            -1, 1, 1, 2
        )

    columns = np.array([[1.0, 0.0], [0.0, 10.0]]).reshape(2, 1, 1, 2)
    far = np.full(2, 99.0)
    problem = Problem(
        np.array([[[0.0, 10.0]]]), predict, lambda _z, _p: columns, lambda v: v, lambda _e: 1e-9,
        -far, far, np.zeros(2), np.zeros(2),
    )  # fmt: skip
    at = problem.points([np.zeros(2)])[0]._replace(predicted=np.zeros((1, 1, 2)))
    move = np.array([0.0, 1.0])
    ends = _DampedSteps(problem, at, columns).second_order(
        [move], [1e-9], problem.points([PROBE * move])
    )
    assert [list(point.z) for point, _ in ends] == [pytest.approx(end)] * (end is not None)


@pytest.mark.parametrize(
    ("slope", "damping", "end", "next_damping"),
    [
        # a slope that is right: the undamped step, and next time a tenth of the damping
        (1.0, 1e-3, 1.0, 1e-4), (1.0, 1e-7, 1.0, 1e-7),
        # 0.757 and 0.735 of what was promised, where three quarters are enough
        (0.67, 1.0, 1.0 / 0.67, 0.1), (0.66, 1.0, 1.0 / 0.66 / 2.0, 1.0),
        # three times too far: of a tenth of the damping, the same and ten times it the best one
        (1.0 / 3.0, 1.0, 1.5, 1.0), (1.0 / 3.0, 10.0, 1.5, 1.0), (1.0 / 3.0, 0.3, 0.75, 3.0),
        # nothing is lower: ten times the damping, ten at most
        (1.0 / 3.0, 0.01, 0.0, 0.1), (-1.0 / 3.0, 0.5, 0.0, 5.0), (-1.0 / 3.0, 10.0, 0.0, 10.0),
    ],
)  # fmt: skip
def test_damping_follows_what_lowers_the_error(slope, damping, end, next_damping):
    """z = 1, from 0, with a slope that may be wrong: the step is 1 / slope / (1 + damping)."""
    nothing, wide = np.zeros(1), np.full(1, 9.0)
    problem = Problem(
        np.ones((1, 1, 1)), lambda points: np.array(points).reshape(-1, 1, 1, 1),
        lambda _z, _p: np.ones((1, 1, 1, 1)), lambda v: v, lambda _e: 1e-9, -wide, wide,
        nothing, nothing,
    )  # fmt: skip
    steps = _DampedSteps(problem, problem.points([nothing])[0], np.full((1, 1, 1, 1), slope))
    assert steps.promised == pytest.approx(1.0)
    point, found = steps.best(damping)
    assert (point.z[0], found) == pytest.approx((end, next_damping), rel=1e-6)


@pytest.mark.parametrize("most", [0, 1, 2, 5])
def test_no_more_jacobians_are_made_than_allowed(most):
    """The first one is not counted."""
    problem, asked = _bent(300.0)
    end = descend(problem, np.array([-1.2, 1.0]), jacobians=most)
    assert asked[0] == 1 + most and end.point.energy > 1.0


def test_no_more_steps_are_made_than_allowed():
    problem, _ = _bent(300.0)
    for most in (1, 3):
        assert descend(problem, np.array([-1.2, 1.0]), steps=most).steps == most


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("wall", "jacobians"), [(9.0, 1), (0.5, 2)])
def test_a_step_that_a_wall_has_cut_is_checked(wall, jacobians, sign):
    """A linear problem, whose first step goes as far as was said: inside of all ranges it ends.
    The steps are those of least squares within the ranges."""
    a, asked = np.array([[1.0, 0.0], [1.0, 1.0]]), [0]

    def jacobian(_z: np.ndarray, _predicted: np.ndarray) -> np.ndarray:
        asked[0] += 1
        return a.reshape(2, 1, 1, 2)

    problem = Problem(
        sign * np.array([[[4.0, 3.0]]]), lambda points: np.array(points).reshape(-1, 1, 1, 2) @ a,
        jacobian, lambda v: v, lambda _e: 1e-9,
        *sorted((sign * np.array([-10.0, -10.0]), sign * np.array([wall, 10.0])), key=sum),
        np.zeros(2), np.zeros(2),
    )  # fmt: skip
    end = descend(problem, sign * np.array([-0.25, 1.0]))
    known = np.array([1.0, 3.0] if wall > 1.0 else [0.5, 3.25])
    assert end.point.z == pytest.approx(sign * known, rel=1e-6)
    assert asked[0] == jacobians and end.steps == 2 * jacobians - 1


def test_no_jacobian_is_made_when_none_is_left():
    problem, asked = _bent(100.0)
    given = problem.jacobian(np.array([-1.2, 1.0]), np.zeros(0))
    end = descend(problem, np.array([-1.2, 1.0]), given, jacobians=0)
    assert asked[0] == 1
    assert not end.fresh
    assert end.point.energy < 4.84 + (100.0 * 0.44) ** 2


@pytest.mark.parametrize("given", [True, False])
def test_at_the_bottom_nothing_more_is_asked(given):
    """The Jacobian at the start says that there is nothing to gain."""
    problem, asked = _bent(10.0)
    bottom = np.ones(2)
    columns = problem.jacobian(bottom, np.zeros(0)) if given else None
    end = descend(problem, bottom, columns)
    assert asked[0] == 1 and end.steps == 1 and end.fresh is not given
    assert end.point.z.tolist() == [1.0, 1.0] and end.point.energy == 0.0


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
