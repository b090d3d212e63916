# SPDX-License-Identifier: Apache-2.0
"""The verdict that follows from what was found and what is left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from decisions import decision, rival
from shapes import LONG, OTHER, measured, shape

from flatplank_analysis.discovery import invariants, verdict
from flatplank_analysis.discovery.sources import source_of
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_data.wording import quantity


def judged(found, left="", lawful=None, notes=(), refits=(), monkeypatch=None):
    """The verdict where these effects were found and this is left, before and after polishing."""
    floors, polished = [SimpleNamespace(floor=1.0)], object()
    state = SimpleNamespace(floors=floors, runs=measured(0).runs)
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
    there = f"other of 20 % is in the data, but below the size that matters ({matters})"
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


def test_why_a_campaign_cannot_be_decided():
    runs = measured(0).runs
    assert verdict.undecidable(runs) == verdict.undecidable(runs.subset(np.arange(6))) == ""
    assert verdict.undecidable(replace(runs, contradicted=("one", "other"))) == "one; other"
    assert verdict.undecidable(runs.subset(np.arange(5))).startswith("5 runs: at least 6 ")
    same = np.zeros(runs.runs, dtype=int)
    one = replace(runs, condition=same, condition_names=("one",))
    assert verdict.undecidable(one).startswith("one condition only")
