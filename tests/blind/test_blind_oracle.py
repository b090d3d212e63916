# SPDX-License-Identifier: Apache-2.0
"""The limit of the data: closed forms, and more that is unknown never makes it better."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cho_factor

from flatplank_validation.evaluation.oracle import noncentrality

SHAPE = (3, 2, 20)


def factors(variance: float) -> list[list]:
    return [[cho_factor(variance * np.eye(SHAPE[2])) for _ in range(SHAPE[1])] for _ in range(3)]


def drawn(count: int, seed: int = 4) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((count, *SHAPE))


def test_of_a_change_beside_nothing_is_its_square_over_the_variance():
    (change,) = drawn(1)
    found = noncentrality(change, np.empty((0, *SHAPE)), np.empty(0), factors(4.0))
    assert found == pytest.approx(np.sum(change**2) / 4.0)


@pytest.mark.parametrize("variance", [0.01, 1.0, 100.0])
def test_of_a_change_beside_an_error_of_its_own_form(variance):
    (change,) = drawn(1)
    energy = np.sum(change**2)
    found = noncentrality(change, change[None], np.array([1.0 / variance]), factors(1.0))
    assert found == pytest.approx(energy / (1.0 + variance * energy), rel=1e-9)


def test_what_a_free_parameter_imitates_is_not_seen():
    columns = drawn(4)
    change = columns[0] - 2.0 * columns[3]
    assert noncentrality(change, columns, np.full(4, 1e-12), factors(1.0)) < 1e-6


def test_more_unknowns_show_less():
    change, *columns = drawn(9)
    all_ = np.array(columns)
    found = [noncentrality(change, all_[:k], np.full(k, 0.1), factors(1.0)) for k in range(9)]
    assert found == sorted(found, reverse=True)
