# SPDX-License-Identifier: Apache-2.0
"""The verdict that follows from what was found and what is left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from decisions import decision, rival
from shapes import LONG, OTHER, measured, searched, shape

from flatplank_analysis.discovery import invariants, verdict, where
from flatplank_analysis.discovery.patterns import Pattern
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_analysis.discovery.verdict import diagnose as unasked
from flatplank_analysis.discovery.view import cause_dict
from flatplank_data.wording import quantity


def judged(found, left="", lawful=None, notes=(), refits=(), monkeypatch=None):
    """The verdict where these effects were found and this is left, before and after polishing."""
    state, polished = SimpleNamespace(floors=[SimpleNamespace(floor=1.0)]), object()
    monkeypatch.setattr(invariants, "residual_of_consequence", lambda *_: lawful)
    steps = SimpleNamespace(state=state, found=found, screen=None, refits=refits, left=left)
    search = SimpleNamespace(with_law_effects=None if lawful is None else polished, notes=notes)
    return verdict._verdict(search, steps)


def test_verdicts(monkeypatch):
    def told(*given, **more):
        return judged([*given], monkeypatch=monkeypatch, **more)

    one = AcceptedEffect(decision())
    free = AcceptedEffect(decision(shape("free", LONG.form, generic=True)))
    group = replace(one, rivals=tuple(rival(f"r{i}", False) for i in range(3)))
    crowd = replace(one, rivals=tuple(rival(f"r{i}", False) for i in range(4)))
    assert told()[0] == verdict.AT_FLOOR
    assert told(left="5 N")[0] == verdict.NONE and "5 N" in told(left="5 N")[1]
    slight = [
        decision(OTHER, size, reasons=("present, negligible",), drop=size) for size in (0.1, 0.2)
    ]
    matters = quantity(OTHER.main_parameter().matters, "1")
    there = f"other of 0.2 is in the data, but below the size that matters ({matters})"
    assert there in told(left="5 N", refits=slight)[1]
    assert "no effect" in told(left="5 N", refits=[decision(reasons=("P = 0.5",))])[1]
    assert told(left="5 N", lawful="4 N")[0] == verdict.NONE
    assert told(left="5 N", lawful="")[0] == verdict.LAW
    assert "machine is in order" in told(left="5 N", lawful="")[1]
    assert "machine is in order" not in told(left="5 N", lawful="", notes=["slow: P = 0.4"])[1]
    assert told(free)[0] == told(free, left="5 N", lawful="")[0] == verdict.LAW
    assert told(free, left="5 N")[0] == verdict.PARTLY
    assert told(one, left="5 N") == (verdict.PARTLY, "5 N")
    assert "another form" in told(one, left="5 N", lawful="")[1]
    assert told(one)[0] == told(one, free)[0] == verdict.FOUND
    assert told(one, group)[0] == verdict.GROUP and "cannot be told apart" in told(group)[1]
    assert "more than four" in told(crowd)[1] and "more than four" not in told(group)[1]


def test_the_clearest_pattern_is_told_where_something_is_left(monkeypatch):
    """Its place is that of the maps, and the period that of a wave; without one a period counts
    from a fifth of the energy on."""
    search = searched(measured(0), LONG)  # its verdicts are made up: `conftest.py` does not ask
    facts = dict(coordinate="time", unit="s", start=1.0, end=1.5, size=0.2, under="", p_value=1e-9)
    wave_, bump = (Pattern(period=period, **facts) for period in (0.31, np.nan))

    def told(name, pattern, reason="5 N", share=0.21):
        state = search.last.state
        known = SimpleNamespace(
            strongest=lambda *_: pattern, ranges=lambda p: {"time": (p.start, p.end)}
        )
        monkeypatch.setitem(vars(state), "patterns", known)
        monkeypatch.setattr(verdict, "_verdict", lambda *_: (name, reason))
        monkeypatch.setattr(verdict, "_period", lambda *_: (0.08, share))
        found = unasked(search)
        place = found.maps[0].place if found.maps[0].place == (1.0, 1.5) else None
        return found.reason, found.period, place

    near = pytest.approx
    for name in (verdict.NONE, verdict.PARTLY):
        assert told(name, None) == ("5 N", 0.08, None)
        assert told(name, None, share=0.19) == ("5 N", near(np.nan, nan_ok=True), None)
        words = "5 N; clearest is a wave of 0.31 s over time"
        assert told(name, wave_, share=0.0) == (words, 0.31, (1.0, 1.5))
        words = "5 N; clearest is a bump over time within 1 to 1.5 s"
        assert told(name, bump) == (words, 0.08, (1.0, 1.5))
        assert told(name, bump, bump.words()) == (bump.words(), 0.08, (1.0, 1.5))
    assert told(verdict.AT_FLOOR, wave_, share=0.0)[0] == "5 N"


def test_the_law_is_fitted_where_something_is_left(monkeypatch):
    monkeypatch.setattr(verdict, "fit_with_law_effects", lambda search: "fitted")
    monkeypatch.setattr(verdict, "_verdict", lambda *_: (verdict.AT_FLOOR, "nothing"))
    for left, fitted in (("5 N", "fitted"), ("", None)):
        search = searched(measured(1, (0.05, LONG.form)), LONG)
        search.last.left = left
        found = unasked(search)
        assert found.search.with_law_effects == fitted
        assert len(found.search.steps) == len(found.found) + 1 == 2
        assert found.verdict == verdict.AT_FLOOR
        before = search.steps[0].state
        assert found.rmse_before == found.search.model.runs.rmse(before.residual[0])


def test_a_campaign_that_cannot_be_decided_is_told_with_its_source():
    runs = measured(0).runs.subset(np.arange(0, 9, 3))
    told = verdict.undecidable_diagnosis(runs, 2.0).to_dict()
    assert told["verdict"] == verdict.UNDECIDED and told["reason"] == verdict.undecidable(runs)
    assert told["effects"] == [] and told["seconds"] == 2.0 and told["runs"] == 0
    assert source_of(runs).to_dict().items() <= told.items()


def test_programs_get_six_digits_and_nothing_where_there_is_no_number():
    none = verdict.undecidable_diagnosis(measured(0).runs, 2.3456)
    numbers = {
        "floor": "floor_rmse", "rmse_before": "rmse_before", "rmse_after": "rmse_after",
        "held_out_before": "held_out_before", "held_out_after": "held_out_after",
    }  # fmt: skip
    left = {"unexplained": "rmse", "varying": "varying", "period": "period"}
    left["coherence"] = "coherence"
    told = none.to_dict()
    assert told["seconds"] == 2.35 and told["limits"] is None and told["detectable"] == {}
    assert [told[key] for key in numbers.values()] == [None] * len(numbers)
    assert [told["unexplained"][key] for key in left.values()] == [None] * len(left)
    names = [*numbers, *left]
    given = {name: (i + 1) * 1.23456789 for i, name in enumerate(names)}
    limits = invariants.Limits(*(0.12345671 * i for i in range(1, 6)))
    sizes = {"drag": (0.01234567, "1/m")}
    told = replace(none, limits=limits, detectable=sizes, notes=("a", "b"), **given).to_dict()
    values = [told[key] for key in numbers.values()]
    values += [told["unexplained"][key] for key in left.values()]
    assert values == [float(f"{given[name]:.6g}") for name in names]
    assert told["limits"] == {
        "rest": 0.123457, "stretch": 0.246913, "error_found": 0.37037, "bump": 0.493827,
        "wave": 0.617284,
    }  # fmt: skip
    assert told["detectable"] == {"drag": {"size": 0.0123457, "unit": "1/m"}}
    assert told["notes"] == ["a", "b"]


def test_programs_get_what_is_known_of_an_effect():
    others = (rival("alike", False), rival("like", True))
    found = AcceptedEffect(
        decision(size=0.123456789, held_out_gain=0.5123456, probability=0.98765432), rivals=others
    )
    told = cause_dict(found)
    assert (told["name"], told["kind"], told["unit"]) == ("long", "machine", "1")
    assert told["size"] == told["parameters"]["a"] == 0.123457
    assert told["interval"] == [0.0617284, 0.185185] and told["held_out_gain"] == 0.512346
    assert told["probability"] == 0.987654 and told["text"]["probability"] == "P = 0.988"
    assert told["class"] == ["alike"] and told["weakly"] == ["like"]
    assert [a["name"] for a in told["members"]] == ["long", "alike"]


def test_programs_get_the_four_clearest_places_of_a_residual():
    runs = measured(0).runs.subset(np.arange(0, 9, 3))
    bins = np.linspace(0.0, 2.0, 3)
    maps = [
        where.Map(name, "m", bins, np.zeros((3, 2)), np.zeros(2), 0.0, 1.0, (0.5, 1.25), 0.75)
        for name in "abcdef"
    ]
    told = replace(verdict.undecidable_diagnosis(runs, 2.0), maps=tuple(maps)).to_dict()
    assert [m["coordinate"] for m in told["unexplained"]["where"]] == ["a", "b", "c", "d"]
    assert told["unexplained"]["where"][0]["range"] == [0.5, 1.25]
    assert told["unexplained"]["where"][0]["share"] == 0.75


def test_why_a_campaign_cannot_be_decided():
    runs = measured(0).runs
    assert verdict.undecidable(runs) == verdict.undecidable(runs.subset(np.arange(6))) == ""
    assert verdict.undecidable(replace(runs, contradicted=("one", "other"))) == "one; other"
    assert verdict.undecidable(runs.subset(np.arange(5))).startswith("5 runs: at least 6 ")
    same = np.zeros(runs.runs, dtype=int)
    one = replace(runs, condition=same, condition_names=("one",))
    assert verdict.undecidable(one).startswith("one condition only")


def test_a_base_that_is_far_off_is_told_before_what_reduces_its_error(monkeypatch):
    search = searched(measured(1, (0.05, LONG.form)), LONG)
    near = unasked(search)
    assert near.found and "far off" not in near.reason
    monkeypatch.setattr(invariants, "far_off", lambda _state: "9 of 10 in x")
    told = unasked(search)
    assert [f.decision for f in told.found] == [f.decision for f in near.found]
    assert told.reason.startswith(
        "the base is far off in every condition, worst 9 of 10 in x, from 1 starts: check sign "
        "and unit of each column; if they are right, "
    )
    assert told.reason.endswith(near.reason)


def test_what_stands_beside_a_verdict(monkeypatch):
    """One step position, what the search notes, and numbers at their ends."""
    ends = {"white": {"g": "g = 15", "late": "late = 0.1"}, "plain": {"late": "late = 0.1"}}
    monkeypatch.setattr(invariants, "parameters_at_ends", lambda _fitter, fit: ends.get(fit, {}))
    monkeypatch.setattr(invariants, "parameters_without_column", lambda fit: fit == "none" and "z")

    def notes(steps=(), noted=(), fits=("", "")):
        state = SimpleNamespace(fitter=None, whitened=SimpleNamespace(fit=fits[0]), fit=fits[1])
        last = SimpleNamespace(state=state, left="")
        runs = SimpleNamespace(facts={"step": np.array(steps)} if steps else {})
        search = SimpleNamespace(last=last, notes=noted)
        return list(verdict._notes(runs, search))

    assert notes() == notes(steps=(1.0, 1.06)) == notes(steps=(np.nan, np.nan)) == []
    for steps in ((1.0, 1.04, np.nan), (2.0,)):
        (note,) = notes(steps=steps)
        assert note.startswith("one step position in all runs")
    assert notes(noted=("slow: P = 0.4",)) == ["slow: P = 0.4"]
    assert notes(fits=("none", "")) == ["no sample of these runs shows z: not fitted"]
    assert notes(fits=("white", "plain")) == ["at an end of its range: g = 15, late = 0.1"]
    assert notes(fits=("", "plain")) == ["at an end of its range: late = 0.1"]


def test_a_period_is_looked_for_only_where_something_is_left():
    """Over the plank; a wave of 8 cm in every condition."""
    runs = measured(0).runs
    place = np.linspace(0.0, 4.0, 480) * np.ones((runs.runs, 1))
    runs = replace(
        runs, measured=np.zeros((1, *place.shape)), time=place,
        coordinates={"plank position": Coordinate(place, "m", local=True)},
    )  # fmt: skip
    residual = np.cos(2.0 * np.pi * place / 0.08)
    for name in (verdict.NONE, verdict.PARTLY):
        period, share = verdict._period(runs, residual, name)
        assert period == pytest.approx(0.08, rel=0.01) and share == pytest.approx(1.0, rel=0.05)
    # the shortest that is looked for is 15 mm
    short = np.cos(2.0 * np.pi * place / 0.024)
    assert verdict._period(runs, short, verdict.NONE)[0] == pytest.approx(0.024, rel=0.01)
    elsewhere = replace(runs, coordinates={"angle": runs.coordinates["plank position"]})
    for told in (
        verdict._period(runs, residual, verdict.AT_FLOOR),
        verdict._period(elsewhere, residual, verdict.NONE),
    ):
        assert np.isnan(told[0]) and told[1] == 0.0
