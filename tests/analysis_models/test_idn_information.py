# SPDX-License-Identifier: Apache-2.0
"""What data leave open, and the run that would tell it, by plain linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flatplank_analysis.identify.mf import information as info
from flatplank_analysis.identify.results import Confusion


def test_directions_that_rows_leave_open():
    jac = np.array([[4.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    (worst, other) = info.undetermined(jac, np.array([1.0, 1.5, 1.0]))
    np.testing.assert_allclose(np.abs(worst), [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(np.abs(other), [0.0, 1.0, 0.0], atol=1e-9)
    assert len(info.undetermined(jac, np.array([1.0, 2.5, 1.0]))) == 1
    assert len(info.undetermined(np.zeros((0, 3)), np.ones(3))) == 3
    assert info.members(np.array([1.0, -0.3, 0.2, -0.26])).tolist() == [0, 1, 3]
    # two open directions in few parameters each
    turn = np.array([[0.6, 0.6, 0.5, 0.0], [0.6, 0.6, -0.5, 0.1]])
    sparse = info._sparse(list(turn))
    assert min(np.count_nonzero(np.abs(row) > 0.2) for row in sparse) == 1
    space = np.linalg.svd(turn)[2][:2]
    for row in sparse:
        assert np.linalg.norm(space @ row) == pytest.approx(1.0) == np.linalg.norm(row)
    weak = info._weakest(
        np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 3.0]]), np.ones(3), np.array([0, 1])
    )
    np.testing.assert_allclose(np.abs(weak), [0.5**0.5, 0.5**0.5, 0.0], atol=1e-9)
    assert weak[0] * weak[1] < 0.0
    pairs = np.array([[1.0, -0.985, 0.99], [-0.985, 1.0, 0.97], [0.99, 0.97, 1.0]])
    assert info._pairs(pairs, np.zeros(3, bool)) == [(0, 1), (0, 2)]
    assert info._pairs(pairs, np.array([False, True, False])) == [(0, 2)]


def test_the_run_that_tells_most_is_proposed_when_it_tells_enough():
    jac, sizes = np.array([[1.0, 0.0]]), np.array([1.0, 2.0])
    offers = [info.Candidate(t, "h", np.array([[a, b]])) for t, a, b in
              (("a", 0.0, 0.3), ("b", 0.0, 1.0), ("c", 2.0, 0.2))]  # fmt: skip
    open_one = np.array([0.0, 1.0])
    assert info._best_run(open_one, sizes, offers, jac).text == "b"
    assert info._best_run(open_one, sizes, offers[:1], jac) is None
    known = np.array([1.0, 0.0])
    assert info._best_run(known, sizes, offers, jac) is None  # 4 < 8 times what is known
    assert info._best_run(0.5 * known, sizes, [replace(offers[2], rows=3.0 * offers[2].rows)],
                          jac).text == "c"  # fmt: skip
    assert info._best_run(known, sizes, [], jac) is None
    # eight times what is known cuts the error to a third
    for slip, told in ((8.1**0.5, True), (7.9**0.5, False)):
        one = info.Candidate("d", "h", np.array([[slip, 0.0]]))
        assert (info._best_run(known, sizes, [one], jac) is not None) is told


def test_wide_errors_and_strong_pairs_are_said():
    names, sizes = ("A", "B", "C", "D"), np.ones(4)
    jac = 10.0 * np.eye(4)
    correlation = np.eye(4)
    correlation[0, 1] = correlation[1, 0] = 0.99
    errors = np.array([0.1, 0.1, 1.1, 1.2])
    found, mask = info.confusions(names, jac, sizes, correlation, list, errors)
    assert mask.tolist() == [False, False, True, True]
    assert [c.names for c in found] == [("C", "D"), ("A", "B")]
    assert found[0].statement == "C and D are not determined by these data"
    assert found[1].statement == "A and B are hard to tell apart with these data"
    assert found[1].correlation == 0.99 and "no single setting" in found[1].remedy
    assert info.confusions(names, jac, sizes, np.eye(4), list)[0] == []
    one = Confusion(("A",), 1.0, "A is not determined by 2 loads", "x")
    other = Confusion(("B",), 1.0, "B is not determined by 2 slips", "y")
    third = Confusion(("C",), 1.0, "C is not determined by 2 loads", "z")
    merged = info._merged([one, other, third, replace(one, names=("D",), remedy="z")])
    assert {c.correlation for c in merged} == {1.0}
    assert [(c.names, c.remedy) for c in merged] == [(("A", "C", "D"), "z"), (("B",), "y")]


def test_bounds_of_what_counts_as_told():
    """An error of half a size that matters; a quarter of the largest part; 0.98; a third."""
    sizes = np.array([1.0, 2.0])
    for told, count in ((2.01, 0), (1.99, 1)):
        assert len(info.undetermined(np.diag([told, 9.0]) / sizes, sizes)) == count
    assert info.members(np.array([0.8, 0.2, -0.199])).tolist() == [0, 1]
    for value, count in ((0.981, 1), (-0.981, 1), (0.979, 0)):
        pair = np.array([[1.0, value], [value, 1.0]])
        assert len(info._pairs(pair, np.zeros(2, bool))) == count
    unknown = np.array([0.0, 1.0])
    for row, useful in ((0.51**0.5, True), (0.49**0.5, False)):
        one = info.Candidate("a", "h", np.array([[0.0, row / 2.0]]))
        best = info._best_run(unknown, sizes, [one], np.array([[1.0, 0.0]]))
        assert (best is one) is useful


def test_statements_of_one_of_a_group_and_of_a_pair():
    names, sizes = ("A", "B", "C"), np.ones(3)
    offers = [info.Candidate("more", "2 loads", 9.0 * np.eye(3))]

    def said(index, correlation, given):
        index = np.array(index)
        direction = np.zeros(3)
        direction[index] = 1.0
        made = info._statement(
            names, index, correlation, direction, sizes, given, np.zeros((1, 3))
        )
        return made.names, made.correlation, made.statement, made.remedy

    no = "no single setting would; fix one in the fit file"
    assert said([1], 1.0, offers) == (
        ("B",), 1.0, "B is not determined by 2 loads", "measure more")  # fmt: skip
    assert said([1], 1.0, []) == (("B",), 1.0, "B is not determined by these data", no)
    assert said([0, 1, 2], 1.0, offers)[2] == "A, B and C cannot be told apart with 2 loads"
    assert said([0, 2], -0.99, [])[1:3] == (
        -0.99,
        "A and C are hard to tell apart with these data",
    )
