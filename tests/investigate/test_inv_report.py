# SPDX-License-Identifier: Apache-2.0
"""The page of a log written by hand: handed back, not confirmed, a proposal at the end."""

from __future__ import annotations

import json

import pytest

from flatplank_analysis.investigation.notebook import entries_of, summary, text_of
from flatplank_analysis.investigation.report import write_notebook

RUN = {"kappa": 0.02, "start": 1, "step_position": 1.5, "fz": 3700, "pressure": 2.5}


def _batch(number: int, what: str, minutes: float, count: int = 1) -> dict:
    return {
        "event": "batch", "number": number, "what": what, "reason": "to test <a> & b",
        "settings": [RUN] * count, "minutes": minutes, "changes": 0, "expected": 1.5, "plan": "",
    }  # fmt: skip


def _answer(number: int, log_e: float, **more) -> dict:
    return {
        "event": "answer", "number": number, "files": [f"{number}.parquet"], "handed_back": [],
        "bet": ["wear"], "log_e": log_e, "answer": "none of these (12 N left)", "effects": [],
        **more,
    }  # fmt: skip


@pytest.fixture
def events(tmp_path):
    file = tmp_path / "proposed_bump.py"
    file.write_text("class Bump: ...\n")
    told = {"error": 25.0, "error_alone": 30.0, "floor": 20.0}
    decoys = {"looked_at": 20, "accepted": ["decoy_of_wear"]}
    v = {"verdict": "none of these", "reason": "12 N are left", "effects": []}
    return [
        {"event": "begin", "minutes": 60.0, "files": ["a", "b"]},
        _batch(1, "slip +2 % once more", 6.0),
        _answer(1, 1.5, decoys={"looked_at": 20, "accepted": []}, **told),
        _batch(2, "slip +5 %, a new level", 12.0, 2),
        _answer(2, 0.0, handed_back=[RUN], decoys=decoys, **told),
        _batch(3, "slip -5 % once more", 6.0),
        {**_answer(3, 0.5), "files": [], "answer": "no good run: handed back"},
        {
            "event": "end", "why": "budget spent", "reason": "2 minutes are left", "verdict": v,
            "proposal": {"verdict": "proposed", "reason": "a force", "file": str(file)},
        },
    ]  # fmt: skip


def test_every_batch_has_its_minutes_and_what_it_answered(events):
    first, second, third = entries_of(summary(events))
    minutes = [(e["since"], e["until"], e["runs"]) for e in (first, second, third)]
    assert minutes == [(0, 6, "run 3"), (6, 18, "runs 4 to 5"), (18, 24, "run 6")]
    assert first["evidence"] == "for wear against the tire alone: e = 4.48, so far e = 4.48"
    assert second["evidence"].startswith("no evidence from these: the runs before do not tell")
    assert second["back"] == ["slip +2 %, start 1"]
    assert third["so_far"] == pytest.approx(2.0)


def test_the_page_has_it_all(events, tmp_path):
    page = write_notebook(events, tmp_path / "page", "a bench").read_text()
    for words in (
        "none of these (12 N are left); e = 7.39 against the tire alone", "24 of 60 minutes",
        "Decoys accepted: 1 of 40", "to test &lt;a&gt; &amp; b", "minute 6 to 18, cost 12 min",
        "25.0 N (30.0 N with the tire alone), floor 20.0 N", "decoy_of_wear", "handed back",
        "End: budget spent", "proposed: a force; written to", "class Bump: ...",
    ):  # fmt: skip
        assert words in page, words
    assert "diagnosis/index.html" not in page
    told = json.loads((tmp_path / "page" / "investigation.json").read_text())
    assert told["decoys"] == {"looked_at": 40, "accepted": ["decoy_of_wear"]}
    assert "a guess until `flatplank confirm` has seen new runs" in text_of(events)


def test_a_log_that_has_not_ended_and_one_of_an_older_version_are_written(events, tmp_path):
    page = write_notebook(events[:2], tmp_path, "a bench").read_text()
    assert "under way" in page
    assert "It has not ended yet" in page
    assert "<svg" not in page
    old = [
        {k: v for k, v in e.items() if k not in ("decoys", "error", "error_alone", "floor")}
        for e in events
    ]
    assert "Decoys accepted: 0 of 0" in write_notebook(old, tmp_path, "a bench").read_text()
