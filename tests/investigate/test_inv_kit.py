# SPDX-License-Identifier: Apache-2.0
"""What the kit counts, on entries written by hand; no loop is run."""

from __future__ import annotations

import json

import pytest

from flatplank_analysis.investigation.settings import SLIPS, STARTS, Setting
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP
from flatplank_validation.blind.journal import published
from flatplank_validation.investigate.cases import _next_three, alarm, fixed, named_run, right
from flatplank_validation.investigate.page import TITLE, lines
from flatplank_validation.verbs.bench_investigate import main


def _entry(
    hidden: str, policy: str, named, minutes: float, log_e: float = 5.0, n: int = 0
) -> dict:
    return {
        "key": f"{hidden}/{policy}/menu/{n}", "seed": 1, "code": "c", "commit": "k", "size": 1.0,
        "hidden": hidden, "verdict": "found", "named": named, "minutes": minutes, "runs": 7,
        "log_e": log_e, "ended": "decided", "planning": [1.0, 3.0], "decoys": [10, 1],
    }  # fmt: skip


ENTRIES = [
    _entry("wear", "loop", [["wear"]], 50.0),
    _entry("wear", "fixed", [["wear"]], 172.0),
    _entry("worn_patch", "loop", [["worn_patch"], ["wear"]], 180.0),
    _entry("worn_patch", "fixed", [["road_play", "worn_patch"]], 172.0),
    _entry("nothing", "loop", [["wear"]], 90.0, log_e=5.0),
    _entry("nothing", "loop", [["wear"]], 90.0, log_e=1.0, n=1),
    _entry("nothing", "loop", [], 90.0, log_e=5.0, n=2),
]


def test_right_and_alarm():
    assert [right(e) for e in ENTRIES] == [True, True, False, True, False, False, True]
    assert [alarm(e) for e in ENTRIES[4:]] == [True, False, False]


def test_the_lines_and_the_page_count_them(tmp_path):
    journal, page = tmp_path / "j.jsonl", tmp_path / "page.md"
    journal.write_text("".join(json.dumps(e) + "\n" for e in ENTRIES))
    page.write_text("# By hand\n\n" + TITLE + "\nold\n")
    words = ["--no-run", "--any-code", "--seed", "1", "--nulls", "3", "--journal", str(journal)]
    for _ in range(2):
        assert main([*words, "--write", str(page)]) == 0
    text = page.read_text()
    assert text.startswith("# By hand\n\n" + TITLE)
    assert text.count(TITLE) == 1
    assert "old" not in text
    for told in (
        "from 7 investigations of seed 1: 5 of the loop, 2 of the plan of 27 runs; 3 loops with "
        "nothing hidden",
        "| the loop | 1/2 = 50%", "| 2/3 = 67%", "| 1/3 = 33%", "| the plan of 27 runs | 2/2",
        "more than the plan in 1/2 = 50%", "Decoys of 5 loops: 5 of 50 accepted",
        "3.0 s at most, of 10", "| wear | 1/1, 50 min | 1/1, 172 min |",
    ):  # fmt: skip
        assert told in text, told
    header, entries = published(page.with_suffix(".jsonl.gz"))
    assert header["seed"] == 1
    assert sorted(e["key"] for e in entries) == sorted(e["key"] for e in ENTRIES)
    assert any("loop took 67 %" in line for line in lines(ENTRIES))


def test_the_run_that_a_diagnosis_names_is_made_as_often_as_it_says():
    where = {"kappa": 0.02, "fz": LOAD, "pressure": PRESSURE, "step_position": 2.2}
    settings = where | {"starts": [1, 2, 3]}
    named = {"what": "slip +2 % with the step at 2.2 m", "settings": settings, "repeats": 2}
    made = named_run(named)
    assert [s.start for s in made.settings] == [1, 2, 3, 1, 2, 3]
    assert {(s.kappa, s.step_position) for s in made.settings} == {(0.02, 2.2)}
    for other in ({"speed": 0.0015}, {"starts": [1.5, 2.5, 3.5]}):
        assert named_run(named | {"settings": settings | other}) is None
    assert named_run({}) is None


@pytest.mark.parametrize("count", [0, 1, 4])
def test_else_the_plan_of_27_runs_goes_on(count):
    whole = fixed().settings
    assert len(whole) == len(SLIPS) * len(STARTS)
    made = list(whole[:count])
    wanted = [s for s in whole if s not in made]
    assert list(_next_three(made).settings) == [s for s in wanted if s.kappa == wanted[0].kappa]
    assert _next_three(whole) is None
    assert whole[0] == Setting(SLIPS[0], STARTS[0], STEP, LOAD, PRESSURE)
