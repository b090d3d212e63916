# SPDX-License-Identifier: Apache-2.0
"""Floors without designed repeats: what gives them, and the most that a verdict says on them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from ball import Drag, Wind, throw
from bristles import Truth, campaign, save
from spring import (
    SAMPLES,
    Damper,
    Spring,
    Stiffening,
    measured,
    ramps,
    sine,
    stairs,
    there_and_back,
)

from flatplank_analysis.cli import compare
from flatplank_analysis.cli import diagnose as verb
from flatplank_analysis.contact_patch.denoising import at_rest
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.discovery.sources import (
    SOURCES,
    cut_where_needed,
    scatter_lower_bound,
    source_of,
)
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND, PARTLY, diagnose, undecidable
from flatplank_analysis.inference.search import run_search
from flatplank_data.errors import FlatplankError
from flatplank_validation.blind.nulls import nothing_hidden
from flatplank_validation.verbs import bench_discovery

RECORDS = {
    "laps": (lambda **k: measured(sine(), **k), FOUND),
    "visits": (lambda **k: measured(stairs(), **k), FOUND),
    "ways": (lambda **k: measured(there_and_back(), **k), PARTLY),
    "rest": (lambda **k: measured(*ramps(), rest=(0.05,), **k), PARTLY),
    "resolution": (lambda **k: measured(*ramps(), resolution=(0.1,), **k), PARTLY),
}


def answer(spring: Spring):
    return diagnose(run_search(spring, [Stiffening, Damper]))


@pytest.mark.parametrize(("name", "made", "most"), [(k, *v) for k, v in RECORDS.items()])
def test_the_best_source_is_taken_and_named_and_caps_the_verdict(name, made, most):
    result = answer(made())
    assert result.source.identifier == name and result.source.at_most == most
    assert [f.decision.term.effect.identifier for f in result.found] == ["stiffening"]
    assert result.verdict == most, result.reason
    low, high = result.found[0].decision.interval
    assert low < 4.0 < high
    assert result.source.title in text_of(result)
    told = result.to_dict()
    assert told["floor_from"] == result.source.words() and told["verdict_at_most"] == most
    assert told["floor_is_lower_bound"] is (name in ("rest", "resolution"))
    assert 0.025 < result.floor < 0.12


@pytest.mark.parametrize(("name", "made"), [(k, v[0]) for k, v in RECORDS.items()])
@pytest.mark.parametrize("seed", [pytest.param(3, marks=pytest.mark.long), 4])
def test_nothing_is_named_where_nothing_is(name, made, seed):
    result = answer(made(seed=seed, k=0.0))
    assert not result.found, (name, result.reason)
    assert not result.verdict.startswith("found")


def test_laps_may_begin_after_a_rest():
    """A record that waits before its input moves has laps all the same."""
    waits = np.concatenate([np.zeros(160), np.sin(2.0 * np.pi * np.arange(SAMPLES - 160) / 160)])
    result = answer(measured(waits))
    assert result.source.identifier == "laps"
    assert [f.decision.term.effect.identifier for f in result.found] == ["stiffening"]


@pytest.mark.long
def test_runs_that_differ_by_one_per_cent_are_no_fault_of_the_machine():
    """Without repeats nothing shows what a tire scatters from run to run: the usual counts."""
    tables = nothing_hidden("second", 1004, 3.0, 0.01, once=True)
    result = Session.of_tables(tables).diagnose()
    assert not result.found and result.source.lower_bound
    state = result.search.steps[0].state
    assert tuple(state.metric.scatter) == state.model.usual_scatter


def test_repeats_go_before_everything_else():
    runs = throw(1, 0.0).runs
    assert source_of(runs).identifier == "repeats"
    assert source_of(replace(runs, rest=(0.01,), resolution=(0.01,))).identifier == "repeats"
    other = replace(runs, facts={**runs.facts, "session": np.arange(runs.runs)})
    assert source_of(other).identifier == "sessions"
    same = replace(runs, facts={**runs.facts, "session": np.zeros(runs.runs)})
    assert source_of(same).identifier == "repeats"


def test_the_same_condition_in_other_sessions_allows_partly():
    ball = throw(1, 0.02)
    ball.runs = replace(ball.runs, facts={**ball.runs.facts, "session": ball.runs.order})
    result = diagnose(run_search(ball, [Drag, Wind]))
    assert [f.decision.term.effect for f in result.found] == [Drag]
    assert result.verdict == PARTLY and "other sessions" in result.reason


def test_nothing_gives_no_floor_and_says_what_would():
    ball = throw(4, 0.02, repeats=1)
    why = undecidable(ball.runs)
    assert "no repeats" in why and "noise at rest" in why
    with pytest.raises(FlatplankError, match="no repeats"):
        run_search(ball, [Drag])
    ball.runs = replace(ball.runs, rest=(0.02,))
    assert undecidable(ball.runs) == ""
    assert diagnose(run_search(ball, [Drag, Wind])).verdict in (PARTLY, AT_FLOOR)


def test_a_lower_bound_joins_what_is_known():
    runs = measured(*ramps(), rest=(0.03,), resolution=(0.1,), input_noise=(0.04,)).runs
    assert scatter_lower_bound(runs, 0) == pytest.approx(0.05)


def test_the_noise_at_rest_is_within_a_run_and_from_run_to_run():
    """Runs that differ in the slip alone are repeats while they stand; a start angle or a load has
    a level of its own."""
    random = np.random.default_rng(3)
    kinds = np.repeat([[4000.0, 0.0], [6000.0, 0.0], [4000.0, 1.0]], 100, axis=0)
    levels = 100.0 * kinds[:, 1] + 0.05 * kinds[:, 0] + random.normal(0.0, 8.0, 300)
    still = np.append(np.zeros(40), 0.5)
    runs = [{"plank_position": still, "fx": v + random.normal(0.0, 2.0, 41)} for v in levels]
    assert at_rest(runs, ("fx",), kinds)[0] == pytest.approx(np.hypot(8.0, 2.0), rel=0.1)
    assert at_rest(runs[:1], ("fx",), kinds[:1])[0] == pytest.approx(2.0, rel=0.4)


def test_pieces_repeat_each_other():
    """Every piece of a condition has the same inputs, and the prediction is cut as they are."""
    for name in ("laps", "visits", "ways"):
        whole = RECORDS[name][0]()
        view = cut_where_needed(whole)
        assert view.runs.floor_from == name and view.runs.repeated
        u = view.runs.inputs["stretch"]
        for rows in view.runs.groups:
            assert np.ptp(u[rows], axis=0).max() < 0.02
        np.testing.assert_array_equal(cut_where_needed(view).runs.measured, view.runs.measured)
    assert [s.at_most for s in SOURCES] == sorted(
        (s.at_most for s in SOURCES), key=["found", "partly", "not decidable"].index
    )


@pytest.mark.long
def test_a_campaign_without_repeats_is_judged_by_its_noise_at_rest(tmp_path, capsys):
    slips = (-0.1, -0.05, -0.02, -0.01, 0.01, 0.02, 0.05, 0.1)
    folder = save(campaign(Truth(seed=41, slips=slips, repeats=1, backlash=8e-4)), tmp_path)
    assert compare.main([str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["floor_from"] == "noise at rest (lower bound)"
    page = tmp_path / "page"
    assert verb.main([str(folder), "--json", "--report", str(page)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["verdict"] == PARTLY and told["verdict_at_most"] == PARTLY
    assert "noise at rest (lower bound)" in told["reason"]
    (effect,) = told["effects"]
    assert "drive_backlash" in (effect["name"], *effect["class"])
    drawn = (page / "index.html").read_text(encoding="utf-8")
    assert "the floor is" in drawn and "by noise at rest (lower bound)" in drawn


@pytest.mark.long
def test_scatter_that_looks_ordered_by_chance_is_no_residual():
    """A tire whose grip scatters by 1 %: in one of two hundred such campaigns it falls with the
    order of the runs. Nothing is hidden, and the verdict was `tire law only`."""
    result = Session.of_tables(bench_discovery.tables_of(0)).diagnose()
    first = result.drawable("").steps[0].state.floors[0]
    assert first.varying > 0.6 * first.floor and 1e-3 < first.varying_p < 5e-3
    assert result.verdict == AT_FLOOR, result.reason
