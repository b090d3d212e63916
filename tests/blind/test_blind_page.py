# SPDX-License-Identifier: Apache-2.0
"""Points, shares and the page of the blind kit."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from flatplank_validation.blind import tables
from flatplank_validation.blind.page import page, summary
from flatplank_validation.blind.points import Share, points_of
from flatplank_validation.blind.rival_scores import rival_scores
from flatplank_validation.evaluation.version import of_which_search

HEADER = {"command": "the command", "seed": 1, "whole": 3, "rivals": []}


def test_wilson():
    low, high = Share(19, 20).interval()
    assert (low, high) == pytest.approx((0.7639, 0.9911), abs=1e-3)
    assert str(Share(0, 0)) == "-"


def entry(group, hidden, named, verdict="found", outside=None, where=()):
    effects = [
        {"name": n, "size": s, "class": [], "interval": [0.9 * s, 1.1 * s]} for n, s in named
    ]
    answer = {"outside": outside, "effects": []}
    if outside is None:
        more = {"sized": True, "unit": "1", "detectable": 0.5, "consequence": 0.01}
        answer["effects"] = [{"name": n, "size": 1.0, "class": [], **more} for n in hidden]
    return {
        "key": f"{group}/{'+'.join(hidden)}", "seed": 1, "code": "c", "kit": "k",
        "commit": "abc", "answer": answer,
        "case": {"group": group, "hidden": list(hidden), "world": "second", "factor": 2.0,
                 "rung": "x", "noise": "white", "scatter": 0.01},
        "diagnosis": {"verdict": verdict, "effects": effects, "floor_rmse": 10.0,
                      "rmse_before": 25.0, "held_out_after": 10.5,
                      "unexplained": {"where": list(where)}},
    }  # fmt: skip


def test_the_page_says_how_true_the_stated_probabilities_are():
    one = entry("single", ["wear"], [("wear", 1.0)])
    assert "Stated probabilities" not in page([one], HEADER)
    one["diagnosis"]["posterior"] = {"nothing": 0.0, "effects": {"wear": 0.9}}
    text = page([one], HEADER | {"beside": "12 campaigns that both diagnosed"})
    assert "| 0.9 .. 1 | 1 | 0.900 | 1.000 |" in text
    assert "## Beside the earlier search" in text and "12 campaigns" in text


def test_points():
    good = points_of(entry("single", ["wear"], [("wear", 1.05)]))
    assert good["right"] and good["sizes"][0]["covered"] and good["held_out"] == 1.05
    assert not points_of(entry("single", ["wear"], [("wear", 1.0), ("road_play", 1.0)]))["right"]
    assert points_of(entry("single", ["wear"], [("wear", 1.0), ("tire_law", 1.0)]))["right"]
    assert not points_of(entry("none", [], [("wear", 1.0)]))["right"]
    assert points_of(entry("none", [], [], "tire law only"))["right"]
    assert not points_of(entry("pair", ["wear", "road_play"], [("wear", 1.0)]))["right"]
    place = {"coordinate": "plank position", "range": [2.0, 2.5]}
    found = entry("outside", ["bump"], [], "none of these", place, [place])
    assert points_of(found)["right"]
    elsewhere = dict(place, range=[3.0, 3.5])
    assert not points_of(entry("outside", ["bump"], [], "partly", place, [elsewhere]))["right"]


def test_sizes_of_unlike_units_are_not_covered_and_not_left_out():
    one = entry("single", ["wear"], [("wear", 1.05)])
    one["diagnosis"]["effects"][0]["unit"] = "m"
    for unit, covered in (("m", True), ("1", False)):
        one["answer"]["effects"][0]["unit"] = unit
        (size,) = points_of(one)["sizes"]
        assert size["covered"] is covered and points_of(one)["right"]
    text = page([one], HEADER)
    assert "| 90 % intervals that cover the truth, all (goal 85 .. 95 %) | 0/1 = 0%" in text
    assert "counted as not covering | 0/1 = 0%" in text


def test_the_page_says_what_the_journal_says():
    entries = [
        entry("single", ["wear"], [("wear", 1.05)]),
        entry("single", ["wear"], [("road_play", 1.0)]),
        entry("none", [], [], "at floor"),
    ]
    text = page(entries, HEADER)
    assert "| wear | 2 | road_play 1, wear 1 |" in text or "wear 1, road_play 1" in text
    assert "1/2 = 50 %" in text.replace("50%", "50 %")
    assert summary(entries)["x2"]["hits"] == 1


def test_strict_and_lenient_stand_side_by_side():
    """Rack backlash hidden, road play named: what the answer's own list let pass."""
    twin = entry("single", ["rack_backlash"], [("road_play", 1.0)])
    twin["answer"]["effects"][0]["class"] = ["road_play", "drive_backlash"]
    text = page([twin], HEADER)
    scores, how = [
        line for line in text.splitlines() if line.startswith("| " + tables.ROWS["x2"][0])
    ]
    cells = [c.strip() for c in scores.strip("|").split("|")]
    assert cells[1].startswith("0/1") and cells[-1].startswith("1/1")
    assert how.split("|")[2].strip() == "1"
    assert summary([twin])["x2"] | {"interval": None} == {
        "hits": 0, "trials": 1, "interval": None, "lenient": 1,
    }  # fmt: skip


def test_a_size_below_what_is_of_consequence_is_not_asked_and_is_shown():
    small = entry("single", ["wear"], [], "at floor")
    small["answer"]["effects"][0] |= {"consequence": 0.8}
    assert summary([small])["x2"]["trials"] == 0
    text = page([small], HEADER)
    assert "too small to be of consequence: named rightly or not at all | 1/1" in text
    (row,) = [line for line in text.splitlines() if line.startswith("| wear | 0.5")]
    assert "| 1.6 .. 1.6 |" in row and "0/1" in row


def test_a_missed_effect_is_compared_with_what_the_search_states_of_itself():
    one = entry("single", ["wear"], [], "at floor")
    for stated, cell in (({"size": 1.25, "unit": "1"}, "0.8 x"), ({"size": 1.25, "unit": "m"}, ""),
                         (None, "none")):  # fmt: skip
        one["diagnosis"]["detectable"] = {"wear": stated}
        (row,) = [r for r in page([one], HEADER).splitlines() if r.startswith("| wear | second")]
        assert [c.strip() for c in row.split("|")][4:6] == ["2.0 x", cell]
        below = "0/1" if stated and stated["unit"] == "m" else "1/1"
        row = f"not named: below the smallest size that the search states for itself | {below}"
        assert row in page([one], HEADER)
    # of one that was named beside a false one it has nothing to state
    one = entry("single", ["wear"], [("wear", 1.0), ("road_play", 1.0)])
    (row,) = [r for r in page([one], HEADER).splitlines() if r.startswith("| wear | second")]
    assert row.split("|")[5].strip() == ""


def test_a_force_of_no_consequence_is_not_asked_and_is_shown():
    place = {"coordinate": "plank position", "range": [2.0, 2.5], "size": 8.0, "detectable": 2.0}
    for slight, trials in ((10.0, 0), (5.0, 1)):
        one = entry("outside", ["bump"], [], "at floor", place | {"consequence": slight})
        assert summary([one])["outside2"]["trials"] == trials
        text = page([one], HEADER)
        (row,) = [r for r in text.splitlines() if "too small to be of consequence: said" in r]
        assert ("| 1/1" in row) is (trials == 0)


def test_the_power_curve_says_from_where_it_is_reached():
    def one(ratio, right):
        made = entry("single", ["wear"], [("wear", 1.0)] if right else [], "found")
        made["answer"]["effects"][0]["detectable"] = 1.0 / ratio
        return made

    entries = [
        one(1.0, False),
        *(one(2.0, True) for _ in range(4)),
        one(2.0, False),
        one(4.0, True),
    ]
    (row,) = [r for r in page(entries, HEADER).splitlines() if r.startswith("| wear | 0.25")]
    cells = [c.strip() for c in row.strip("|").split("|")]
    assert cells[3:] == ["0/1", "4/5", "1/1", "-", "-", "1.5 x"]
    assert tables.reached([Share(1, 1), Share(0, 1)]) is None


def test_rivals_are_scored_by_the_same_rule():
    one = entry("single", ["wear"], [("wear", 1.05)])
    near = {"name": "zero_drift", "size": 1.0, "interval": [0.9, 1.1], "class": ["wear"]}
    said = {"effects": [near], "unexplained": {}, "floor_rmse": None, "held_out_after": None}
    one["ways"] = {
        "ours": one.pop("diagnosis"), "a rival": said | {"verdict": "found group"},
        "another": said | {"verdict": "found"},
    }  # fmt: skip
    text = rival_scores([one])
    (row,) = [line for line in text.splitlines() if line.startswith("| one effect: right")]
    assert [c.strip()[:3] for c in row.strip("|").split("|")][1:] == ["1/1", "1/1", "0/1"]
    assert text in page([one | {"diagnosis": one["ways"]["ours"]}], HEADER | {"rivals": [one]})


@pytest.mark.parametrize(
    "name", ["reference/discovery-blind", "guide/propose", "guide/investigate"]
)
def test_a_published_page_says_which_search_its_numbers_are_of(name):
    file = Path(__file__).resolve().parents[2] / "docs" / f"{name}.md"
    with gzip.open(file.with_suffix(".jsonl.gz"), "rt", encoding="utf-8") as journal:
        commits = {json.loads(line).get("commit") for line in journal} - {None}
    assert of_which_search(commits) in file.read_text(encoding="utf-8")
