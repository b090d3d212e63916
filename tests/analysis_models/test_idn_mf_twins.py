# SPDX-License-Identifier: Apache-2.0
"""Second solutions of the slip stiffness over the load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from idn_points import LOADS, TIR, C, points, problem

from flatplank_analysis.identify.least_squares import Solution
from flatplank_analysis.identify.mf import information as candidates
from flatplank_analysis.identify.mf import statement as twins
from flatplank_analysis.identify.mf.problem import OutputProblem, Prior


def solution(x, cost: float = 0.0, n: int = 15) -> Solution:
    residual = np.zeros(n + 2)
    residual[0] = np.sqrt(cost)
    no = np.zeros(len(x), bool)
    return Solution(np.asarray(x, float), residual, np.zeros((n + 2, len(x))), no, no, True, 3)


def test_of_two_solutions_the_better_one_is_taken(monkeypatch):
    """Equally good within 9.2: that of the smaller PKX3."""
    one = problem(free=twins.PAIR)
    found = solution((4.0, 0.5), 100.0)
    for x, cost, mine in (
        ((-4.0, 0.2), 109.3, True), ((-4.0, 0.2), 109.1, False), ((-4.0, -0.6), 109.1, True),
        ((-4.0, 0.9), 90.7, False), ((-4.0, 0.9), 90.9, True),
    ):  # fmt: skip
        other = solution(x, cost)
        monkeypatch.setattr(twins, "_other", lambda *_, other=other: other)
        assert (twins.better_twin(one, found) is found) is mine, (x, cost)
    monkeypatch.setattr(twins, "_other", lambda *_: None)
    assert twins.better_twin(one, found) is found and twins.twin_of(one, found) is None


def test_solutions_are_distinguishable_where_most_repeats_would(monkeypatch):
    """Predictions D apart: D^2 - 2 D beyond 9.2 is D beyond 4.2."""
    one = problem(free=twins.PAIR)
    other = solution((-4.0, 0.2), 120.0)
    for apart, cost, told in ((4.3, 100.0, True), (4.1, 100.0, False), (9.0, 111.0, False)):
        rows = np.zeros((2, 17))
        rows[1, 3], rows[1, 16] = apart, 99.0
        monkeypatch.setattr(OutputProblem, "residuals", lambda *_, rows=rows: rows)
        assert twins._distinguishable(one, solution((4.0, 0.5), cost), other) is told


def test_the_mirrored_pair_has_the_same_stiffness():
    """K = Fz (PKX1 + PKX2 dfz) exp(PKX3 dfz): the logs of the bracket are odd in PKX2."""
    one = problem(free=twins.PAIR)
    dfz = candidates.levels_of(one.points, "fz") / (C.LFZO * C.FNOMIN) - 1.0
    x = np.array([0.3 * C.PKX1, -0.1])
    mirrored = twins._mirrored(one, x)
    both = [np.log(C.PKX1 + s * x[0] * dfz) + p * dfz for s, p in ((1, x[1]), (-1, mirrored))]
    np.testing.assert_allclose(both[0], both[1], atol=0.01)
    odd = np.log((C.PKX1 + x[0] * dfz) / (C.PKX1 - x[0] * dfz))
    inside = np.abs(dfz) > 1e-3
    line = np.linalg.lstsq(dfz[inside, None], odd[inside], rcond=None)[0][0]
    assert mirrored == pytest.approx(x[1] + line)
    # where the bracket would vanish at a load, that load does not count
    steep = twins._mirrored(one, np.array([1.97 * C.PKX1, -0.1]))
    kept = np.abs(1.97 * dfz) < 0.95
    assert kept.sum() == 1 and steep == x[1]
    lone = replace(one, points=one.points.rows(one.points.fz == LOADS[1]))
    if abs(LOADS[1] / (C.LFZO * C.FNOMIN) - 1.0) < 1e-3:
        assert twins._mirrored(lone, x) == x[1]
    load = twins._deciding_load(one, x, np.array([-x[0], mirrored]))
    assert load in (1000.0, 8000.0)
    gap = {}
    for fz in (1000.0, 3000.0, 7000.0, 8000.0):
        d = fz / (C.LFZO * C.FNOMIN) - 1.0
        values = [
            fz * (C.PKX1 + s * x[0] * d) * np.exp(p * d) for s, p in ((1, x[1]), (-1, mirrored))
        ]
        gap[fz] = abs(values[1] - values[0])
    assert load == max(gap, key=gap.get)
    assert twins._other(replace(one, priors={"PKX3": Prior(0.0, 1.0)}), solution(x)) is None
    assert twins._other(problem(), solution(x)) is None
    bound = replace(solution(x), at_upper=np.array([False, True]))
    assert twins._other(one, bound) is None


@pytest.mark.parametrize(
    ("cost", "how"),
    [(109.1, "that fits as well"), (90.9, "that fits as well"),
     (109.3, "that only the noise of these runs excludes")],
)  # fmt: skip
def test_a_second_solution_is_said_with_the_load_that_would_decide(monkeypatch, cost, how):
    one = problem(free=("PKX1", *twins.PAIR))
    found, other = solution((25.0, 4.0, 0.5), 100.0), solution((25.0, -4.25, 0.2), cost)
    monkeypatch.setattr(twins, "_other", lambda *_: other)
    monkeypatch.setattr(twins, "_distinguishable", lambda *_: False)
    monkeypatch.setattr(twins, "_deciding_load", lambda *_: 8000.0)
    said = twins.twin_of(one, found)
    assert (said.names, said.correlation) == (("PKX2", "PKX3"), 1.0)
    assert said.statement == (
        f"PKX2 and PKX3 have a second solution (PKX2 = -4.25, PKX3 = 0.2) {how} with "
        "3 loads (1850 N, 3700 N, 5550 N)"
    )
    assert said.remedy == "measure a load of 8000 N"
    monkeypatch.setattr(twins, "_deciding_load", lambda *_: None)
    assert twins.twin_of(one, found).remedy == "fix one in the fit file"
    monkeypatch.setattr(twins, "_distinguishable", lambda *_: True)
    assert twins.twin_of(one, found) is None


def test_the_load_that_decides_is_new_and_parts_the_stiffnesses_most():
    """K = load (PKX1 + PKX2 dfz) exp(PKX3 dfz); loads within 400 N of the data are no new ones."""
    one = problem(free=("PKX1", *twins.PAIR))
    nominal = C.LFZO * C.FNOMIN
    pairs = (
        ((25.0, 9.0, 0.0), (25.0, 0.0, 0.1)), ((25.0, 0.0, 2.0), (25.0, 0.0, 0.1)),
        ((20.0, 30.0, -2.0), (20.0, 0.0, 0.0)), ((25.0, 1.0, 0.3), (24.0, 1.0, 0.3)),
    )  # fmt: skip
    for first, second in pairs:
        gaps = {}
        for load in (1000.0, 3000.0, 5000.0, 6000.0, 7000.0, 8000.0):
            dfz = load / nominal - 1.0
            one_k, two_k = (load * (a + b * dfz) * np.exp(p * dfz) for a, b, p in (first, second))
            gaps[load] = abs(one_k - two_k)
        found = twins._deciding_load(one, np.array(first), np.array(second))
        assert found == max(gaps, key=gaps.get), (first, second)
    every = np.repeat(1000.0 * np.arange(1, 9), 2)
    full = replace(one, points=points(16, fz=every))
    assert twins._deciding_load(full, np.array(first), np.array(second)) is None


def test_the_mirrored_search_finds_the_other_solution_of_three_loads():
    """Its own residuals, and the weak priors of the first one: they must not judge."""
    free = ("PKX1", *twins.PAIR)
    base = TIR.replaced({"PKX1": 25.0, "PKX2": 6.0, "PKX3": -0.1}).coefficients
    one = problem(free=free, base=base)
    fx = one.predict(np.array([[25.0, 6.0, -0.1]]))[0]
    one = replace(one, points=replace(one.points, measured={"fx": fx}))
    found = one.solve()
    other = twins._other(one, found)
    n = len(one.points)
    assert other.x[1] < 0.0 < other.x[2] and found.x[1] == pytest.approx(6.0, rel=0.02)
    np.testing.assert_allclose(other.residual[:n], one.residuals(other.x[None])[0, :n])
    np.testing.assert_array_equal(other.residual[n:], found.residual[n:])
    for k in (1, 2):
        held = np.arange(3) == k
        assert twins._other(one, replace(found, at_lower=held)) is None
    assert twins._other(one, replace(found, at_upper=np.arange(3) == 0)) is not None
    assert twins._other(replace(one, priors={"PKX2": Prior(0.0, 1.0)}), found) is None


@pytest.mark.parametrize(
    ("away", "bound", "other"),
    [((2.6, 0.0), None, True), ((2.4, 0.24), None, False), ((0.0, -0.26), None, True),
     ((20.0, 0.5), 1, False), ((20.0, 0.5), 2, False), ((20.0, 0.5), 0, True)],
)  # fmt: skip
def test_a_solution_half_a_size_away_and_off_its_bounds_is_another_one(
    monkeypatch, away, bound, other
):
    """Sizes that matter: 5 of PKX2, 0.5 of PKX3."""
    one = problem(free=("PKX1", *twins.PAIR))
    found = solution((25.0, 4.0, 0.5))
    there = solution((25.0, 4.0 + away[0], 0.5 + away[1]))
    if bound is not None:
        there = replace(there, at_lower=np.arange(3) == bound)
    monkeypatch.setattr(twins, "solve", lambda *_: there)
    assert (twins._other(one, found) is not None) is other
