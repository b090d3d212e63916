# SPDX-License-Identifier: Apache-2.0
"""`flatplank bench-discovery`: what it measures, and that a slow search is told."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_validation.verbs import bench_discovery as bench


def test_each_campaign_hides_one_more():
    plain, *others = (bench.tables_of(count, "small") for count in range(4))
    before = plain
    for tables in others:
        moved = [np.abs(a.columns["fx"] - b.columns["fx"]).max()
                 for a, b in zip(before, tables, strict=True)]  # fmt: skip
        assert max(moved) > 10.0
        before = tables


@pytest.mark.long
def test_times_and_memory_are_those_of_a_search():
    found = bench.measure(bench.diagnose, 1, "small")
    assert 0.0 < found["first_ranking"] < found["seconds"]
    assert 0.0 < found["screening"] < 20.0
    assert 100.0 < found["memory"] < 2048.0
    assert "drive_backlash" in found["named"]
