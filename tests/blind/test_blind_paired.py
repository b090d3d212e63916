# SPDX-License-Identifier: Apache-2.0
"""Two searches on the same campaigns, and the reliability of stated probabilities."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest
from scipy.stats import binom

from flatplank_validation.blind import journal
from flatplank_validation.blind.cases import Case
from flatplank_validation.evaluation.paired import (
    claims,
    mcnemar,
    of_the_same,
    paired,
    reliability,
)

MORE = {"sized": True, "unit": "1", "detectable": 0.5, "consequence": 0.01, "class": []}


def entry(number, hidden, named, stated=None):
    effects = [
        {"name": n, "size": 1.0, "class": [], "interval": [0.9, 1.1], "p_value": 0.01}
        for n in named
    ]
    diagnosis = {
        "verdict": "found" if named else "at floor", "effects": effects, "floor_rmse": 10.0,
        "rmse_before": 25.0, "held_out_after": 10.5, "unexplained": {"where": []}, "seconds": 7.0,
    }  # fmt: skip
    case = {"group": "single" if hidden else "none", "hidden": hidden, "world": "second",
            "factor": 2.0, "rung": "x", "noise": "usual", "scatter": 0.01}  # fmt: skip
    return {
        "key": f"k{number}", "seed": 1, "kit": "k", "code": "c", "commit": "x", "case": case,
        "answer": {"outside": None, "effects": [{"name": h, "size": 1.0, **MORE} for h in hidden]},
        "diagnosis": diagnosis | ({"posterior": stated} if stated else {}),
    }  # fmt: skip


def test_campaigns_that_only_one_search_gets_right():
    ours = [entry(i, ["wear"], ["wear"] if i else []) for i in range(4)]
    theirs = [entry(i, ["wear"], ["wear"] if i > 2 else []) for i in range(5)]
    text = paired(ours, theirs)
    assert "4 campaigns" in text
    assert "| all | 1 | 2 | 0 | 1 | 0.5 |" in text
    assert "no campaign in common" in paired(ours, [])


def test_campaigns_of_one_name_in_which_another_size_is_hidden_are_not_compared():
    ours, theirs = ([entry(i, ["wear"], ["wear"]) for i in range(3)] for _ in "ab")
    theirs[1]["kit"] = "another"
    theirs[2]["answer"]["effects"][0]["size"] = 1.1
    assert "2 campaigns" in paired(ours, theirs)
    assert list(of_the_same(ours, theirs)) == ["k0", "k1"]


def test_the_campaigns_of_a_published_journal_are_made_again(tmp_path):
    cases = [Case("pair", "second", ("wear", "road_play"), 3.0), Case("none", "third", number=4)]
    entries = [
        {"key": c.key, "seed": 5, "case": asdict(c), "diagnosis": d, "code": "c"}
        for c, d in zip([*cases, Case("none", "forms")], [{}, {"a": 1}, None], strict=True)
    ]
    entries[0]["diagnosis"] = {"a": 2}
    for path in (tmp_path / "j.jsonl.gz", tmp_path / "j.jsonl"):
        if path.suffix == ".gz":
            journal.publish(path, {"seed": 5}, entries)
        else:
            path.write_text("".join(json.dumps(e) + "\n" for e in entries), encoding="utf-8")
        assert [journal.case_of(e) for e in journal.diagnosed(path)] == cases


def test_mcnemar_is_a_test_of_a_fair_coin():
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(1, 7) == pytest.approx(2.0 * binom.cdf(1, 8, 0.5))


def test_claims_are_those_that_are_stated():
    stated = {"nothing": 0.1, "effects": {"wear": 0.8, "road_play": 0.1}}
    assert list(claims(entry(0, ["wear"], [], stated))) == [
        (0.8, True), (0.1, False), (0.1, False),
    ]  # fmt: skip
    assert list(claims(entry(0, [], [], {"nothing": 0.9, "effects": {}}))) == [(0.9, True)]
    assert list(claims(entry(0, ["wear"], ["road_play"]))) == [(0.99, False)]


def test_calibration_error_is_the_mean_distance():
    right = [entry(i, ["wear"], [], {"nothing": 0.0, "effects": {"wear": 0.9}}) for i in range(9)]
    wrong = [entry(9, ["road_play"], [], {"nothing": 0.0, "effects": {"wear": 0.9}})]
    assert "error 0.000" in reliability(right + wrong)
    assert "error 0.050" in reliability(right)
