# SPDX-License-Identifier: Apache-2.0
"""`flatplank bench-discovery`: what it measures, and that a slow search is told."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_validation.verbs import bench_discovery as bench

GOOD = {
    "runs": 27, "first_ranking": 4.0, "screening": 2.0, "seconds": 5.5, "memory": 700.0,
    "verdict": "at floor", "named": [],
}  # fmt: skip
PROPOSED = {"runs": 27, "seconds": 41.0, "memory": 900.0, "verdict": "proposed"}


def measured(monkeypatch, search=GOOD, proposal=PROPOSED) -> None:
    found = {bench.diagnose: search, bench.proposal: proposal}
    monkeypatch.setattr(bench, "measure", lambda work, *_: found[work])


def test_each_campaign_hides_one_more():
    plain, *others = (bench.tables_of(count, "small") for count in range(4))
    before = plain
    for tables in others:
        moved = [np.abs(a.columns["fx"] - b.columns["fx"]).max()
                 for a, b in zip(before, tables, strict=True)]  # fmt: skip
        assert max(moved) > 10.0
        before = tables


@pytest.mark.parametrize(
    "worse", [{"first_ranking": 5.1}, {"screening": 3.1}, {"seconds": 6.1}, {"memory": 1025.0}]
)
def test_what_is_not_as_wanted_ends_with_one(monkeypatch, capsys, worse):
    monkeypatch.setattr(bench, "WANTED", {0: 6.0})
    measured(monkeypatch)
    assert bench.main([]) == 0
    said = capsys.readouterr().out
    assert (
        "first ranking  4.0 s (<= 5), screening 2.0 base fits (<= 3), all   5.5 s (<= 6)" in said
    )
    assert "propose, 27 runs: 41.0 s (<= 60), memory  900 MiB (<= 1536); proposed" in said
    measured(monkeypatch, search=GOOD | worse)
    assert bench.main([]) == 1


@pytest.mark.parametrize("worse", [{"seconds": 61.0}, {"memory": 1537.0}])
def test_a_slow_proposal_ends_with_one(monkeypatch, worse):
    monkeypatch.setattr(bench, "WANTED", {0: 6.0})
    measured(monkeypatch, proposal=PROPOSED | worse)
    assert bench.main([]) == 1


@pytest.mark.long
def test_times_and_memory_are_those_of_a_search():
    found = bench.measure(bench.diagnose, 1, "small")
    assert 0.0 < found["first_ranking"] < found["seconds"]
    assert 0.0 < found["screening"] < 20.0
    assert 100.0 < found["memory"] < 2048.0
    assert "drive_backlash" in found["named"]
