# SPDX-License-Identifier: Apache-2.0
"""The kit for proposals: what it hides is said in the words of the grammar; journal and page."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from flatplank_analysis.effects.grammar.hooks import HOOKS
from flatplank_analysis.effects.grammar.modulators import BY_NAME
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.registry import library
from flatplank_data.errors import FlatplankError
from flatplank_validation.proposed import journal, rivals
from flatplank_validation.proposed.cases import KIT, Case, full, make
from flatplank_validation.proposed.forces import FORCES
from flatplank_validation.proposed.left_out import LEFT_OUT, removed
from flatplank_validation.proposed.page import TITLE, beside, page, rows_of


def truths():
    random = np.random.default_rng(3)
    yield from (item.make(20.0, random)[1] for item in FORCES.values())
    yield from LEFT_OUT.values()


def test_answers_speak_the_words_of_the_grammar():
    families = {h.family for h in HOOKS}
    for truth in truths():
        assert set(truth.families) <= families
        assert set(truth.shapes) <= set(shapes())
        assert set(truth.modulators) <= set(BY_NAME)


@pytest.mark.long
def test_a_sentence_is_proposed_beside_a_law_of_another_form():
    """A zero that warms up. No difference of stiffness between driving and braking is there, and
    none is named; the sentence takes the error to the floor."""
    case = Case("force", "forms", "warming", "coloured", 0.0, "small", 0)
    assert case in full(70923)
    entry = journal.solve(case, 70923)
    said = entry["proposal"]
    assert said["diagnosis"] == "tire law only" and said["verdict"] == "proposed"
    assert said["shape"] in entry["answer"]["shapes"]
    assert said["coordinate"] in entry["answer"]["coordinates"]
    assert said["modulator"] in entry["answer"]["modulators"]
    assert said["refit"]["rmse"] < 1.05 * said["refit"]["floor"]


@pytest.mark.long
def test_what_is_not_clear_of_zero_is_not_named_and_does_not_hide_a_sentence():
    """That difference of stiffness was named here, too, with a 99 % interval that covers zero."""
    case = Case("force", "second", "warming", "usual", 0.0, "small", 0)
    said = journal.solve(case, 70923)["proposal"]
    assert said["diagnosis"] == "at floor" and said["verdict"] == "proposed"
    assert (said["family"], said["shape"]) == ("signal", "relaxation")


@pytest.mark.long
def test_a_sentence_is_proposed_where_nothing_was_found():
    case = Case("left_out", "forms", "crosstalk_mx", "quiet", 0.0, "small", 1)
    assert case in full(67314)
    said = journal.solve(case, 67314)["proposal"]
    assert said["diagnosis"] == "at floor" and said["verdict"] == "proposed"
    assert (said["family"], said["coordinate"], said["shape"]) == ("signal", "mx", "ramp")


def test_what_is_left_out_was_there():
    for name in LEFT_OUT:
        assert removed(name) <= set(library()) and name in removed(name)


def test_the_list_has_everything_in_every_world():
    cases = full(1)
    assert len({c.key for c in cases}) == len(cases)
    assert sum(c.group == "null" for c in cases) >= 100
    for name in FORCES:
        assert {c.world for c in cases if c.name == name} == set(KIT)
    assert [c.key for c in full(1)] != [c.key for c in full(2)]


def test_a_campaign_has_its_column_and_its_force():
    case = Case("force", "second", "warm")
    tables, answer = make(case, 9)
    column = "temperature [degC]"
    assert len(tables) == 15 and all(column in t for t in tables)
    again, _ = make(case, 9)
    assert np.array_equal(tables[0]["fx"], again[0]["fx"])
    warm = [float(t[column].mean()) for t in tables]
    assert np.ptp(warm) > 5.0 and answer["hidden"] >= 30.0
    seen = max(t[column].max() for t in tables) - min(t[column].min() for t in tables)
    assert answer["size"] == pytest.approx(answer["hidden"] * seen / 14.0)


def entry(group: str, said: bool, size: float = 40.0, **parts) -> dict:
    """A line of a journal, made up."""
    answer = {
        "families": ["signal"], "coordinates": ["time"], "modulators": [""], "shapes": ["ramp"],
        "size": 40.0,
    }  # fmt: skip
    proposal = {"verdict": "nothing to propose", "diagnosis": "at floor", "seconds": 5.0}
    if said:
        refit = {"size": size, "floor": 10.0, "held_out": 10.5, "held_out_level": 14.0,
                 "interval": [size - 5.0, size + 5.0]}  # fmt: skip
        proposal = {
            "verdict": "proposed", "diagnosis": "none of these", "seconds": 9.0, "hook": "fx",
            "family": "signal", "coordinate": "time", "modulator": "", "shape": "ramp",
            "refit": refit, **parts,
        }  # fmt: skip
    case = {"group": group, "name": "it", "world": "second"}
    key = f"{group}/{said}/{size}/{sorted(parts)}"
    return {"key": key, "case": case, "answer": answer, "proposal": proposal, "commit": "c",
            "code": "d"}  # fmt: skip


def test_scores_count_what_they_say():
    other = {"family": "signal", "coordinate": "time", "modulator": "", "shape": "step"}
    entries = [
        entry("force", True),
        entry("force", True, size=60.0),
        entry("force", True, coordinate="load", confused_with=[other]),
        entry("left_out", False),
        entry("null", False),
        entry("null", True),
    ]
    rows = {text: (s.hits, s.trials) for text, _, s in rows_of(entries)}
    assert rows["all: family, coordinate and modulator right"] == (2, 4)
    name = "all: right, or one of the four at most that it says cannot be told apart"
    assert rows[name] == (3, 4)
    assert rows["form right, of all"] == (3, 4)
    assert rows["sentence and form right, sizes comparable: within 15 %"] == (1, 2)
    assert rows["the same: its 90 % interval holds the hidden size"] == (1, 2)
    assert rows["of those proposed: left-out level <= 1.5 floors"] == (3, 3)
    assert rows["nothing hidden: something is proposed"] == (1, 2)
    text = page(entries, {"command": "x", "seed": 1, "whole": 9})
    assert text.startswith(TITLE) and "6 of the 9 campaigns" in text
    rows = text.splitlines()
    assert "| it | 3/4 | 2/4 | 2/4 |" in rows
    assert "| it | second | signal, time, ramp | yes, form | 2 |" in rows
    assert "| it | second | (at floor) | no | 1 |" in rows


def inputs(random, low: float, high: float) -> rivals.Inputs:
    """Two coordinates, on both sides of the slip; the load and a temperature."""
    load, warm = random.uniform(low, high, (2, 600))
    driving = (random.random(600) > 0.5).astype(float)
    return rivals.Inputs(
        {"load": load, "temperature": warm}, {"load": "level", "temperature": "signal"},
        {"": np.ones(600), "driving": driving, "braking": 1.0 - driving},
    )  # fmt: skip


@pytest.mark.parametrize("name", ["free spline", "sparse regression"])
def test_a_rival_finds_the_coordinate_of_a_line(name):
    random = np.random.default_rng(5)
    seen, beyond = inputs(random, 0.0, 1.0), inputs(random, 1.0, 2.0)
    rest = 3.0 * seen.values["temperature"] - 1.5
    claim = rivals.RIVALS[name](seen, rest + 0.05 * random.standard_normal(600))
    assert claim.coordinates == ("temperature",)
    assert np.std(claim.force(seen) - rest) < 0.1
    truth = 3.0 * beyond.values["temperature"] - 1.5
    if name == "sparse regression":  # a spline ends where the data end
        assert claim.shape == "ramp" and np.std(claim.force(beyond) - truth) < 0.2
    else:
        assert not claim.shape and np.std(claim.force(beyond) - truth) > 0.5


def test_without_its_package_a_rival_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyoperon", None)
    monkeypatch.setitem(sys.modules, "pyoperon.sklearn", None)
    seen = inputs(np.random.default_rng(5), 0.0, 1.0)
    with pytest.raises(FlatplankError, match="needs the package pyoperon"):
        rivals.genetic(seen, seen.values["load"])


def test_rivals_stand_beside_the_proposals():
    one = {"said": True, "inside": 0.1, "outside": 0.2, "coordinate": True, "form": True,
           "seconds": 9.0}  # fmt: skip
    other = one | {"outside": 4.0, "coordinate": False, "form": False}
    said = {"flatplank propose": one, "free spline": other}
    nothing = said | {"flatplank propose": {"said": False, "seconds": 5.0}}
    rows = beside([{"said": said}, {"said": nothing}])[-1].splitlines()
    assert rows[2] == "| flatplank propose | 1/2 | 1/2 | 1/2 | 0.55 | 0.60 | 1/2 | 7 |"
    assert rows[3] == "| free spline | 2/2 | 0/2 | 0/2 | 0.10 | 4.00 | 0/2 | 9 |"
