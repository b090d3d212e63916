# SPDX-License-Identifier: Apache-2.0
"""The score: what the program itself said, not what the answer would let pass."""

from __future__ import annotations

import pytest

from flatplank_data.errors import FlatplankError
from flatplank_sim.sealed.score import score, text_of
from flatplank_sim.sealed.seal import unseal

RACK = {
    "name": "rack_backlash", "size": 5e-4, "unit": "m", "class": ["drive_backlash", "road_play"],
}  # fmt: skip


def named(name, *others, size=5e-4, unit="m"):
    interval = [0.9 * size, 1.1 * size]
    return {"name": name, "class": list(others), "size": size, "unit": unit, "interval": interval}


def said(verdict, *effects, **more):
    return {"verdict": verdict, "effects": list(effects), **more}


def test_a_relative_of_what_is_hidden_is_not_right():
    """The answer of seed 7331: road play named alone where the rack has backlash."""
    points = score(said("found", named("road_play")), {"effects": [RACK]})
    assert not points["right"] and points["kin_right"] and not points["first_right"]
    assert points["false"] == ["road_play"]
    assert points["effects"] == [{"name": "rack_backlash", "named": False, "kin": "road_play"}]


def test_the_class_that_the_program_gives_is_right_when_it_says_that_it_is_a_group():
    answer = {"effects": [RACK]}
    group = named("road_play", "rack_backlash", "drive_backlash")
    assert score(said("found group", group), answer)["right"]
    assert score(said("found group", group), answer)["effects"][0]["as"] == "road_play"
    assert not score(said("found", group), answer)["right"]
    assert not score(said("partly", group), answer)["right"]
    many = named("road_play", "rack_backlash", "a", "b", "c")
    assert not score(said("found group", many), answer)["right"]
    assert score(said("found", named("rack_backlash")), answer)["right"]
    # a class of five is no answer, even when it begins with the right name
    assert not score(said("found group", named("rack_backlash", *"abcd")), answer)["right"]


def test_one_name_is_not_counted_for_two():
    both = {"effects": [RACK, dict(RACK, name="road_play")]}
    group = named("drive_backlash", "rack_backlash", "road_play")
    points = score(said("found group", group), both)
    assert [e["named"] for e in points["effects"]] == [True, False]
    pair = said("found group", group, named("rack_backlash"))
    points = score(pair, both)
    assert [e["as"] for e in points["effects"]] == ["rack_backlash", "drive_backlash"]
    assert points["right"]


def test_a_group_with_what_the_tire_really_has_is_not_false():
    answer = {"effects": [], "present": ["rolling_resistance"]}
    group = named("crosstalk_fz", "rolling_resistance")
    points = score(said("found group", group), answer)
    assert points["right"] and not points["false"] and not points["false_alarm"]
    for other in (
        score(said("found", group), answer),
        score(said("found group", named("crosstalk_fz")), answer),
        score(said("found group", group), {"effects": []}),
        score(said("found group", group, named("wear")), answer),
    ):
        assert not other["right"] and other["false"] and other["false_alarm"]
    # it still counts for what is hidden
    asked = answer | {"effects": [dict(RACK, name="crosstalk_fz")]}
    assert score(said("found group", group), asked)["right"]


def test_a_size_in_another_unit_is_not_covered():
    hidden = {"name": "crosstalk_fz", "size": 0.25, "unit": "1", "class": []}
    group = named("runout_2", "crosstalk_fz", size=0.25)
    (one,) = score(said("found group", group), {"effects": [hidden]})["effects"]
    assert one["named"] and not one["comparable"] and not one["covered"] and one["error"] is None
    group["unit"] = "1"
    (one,) = score(said("found group", group), {"effects": [hidden]})["effects"]
    assert one["comparable"] and one["covered"] and one["error"] == 0.0


def test_what_is_wrong_is_counted():
    answer = {"effects": [{"name": "wear", "size": 0.1, "unit": "1", "class": []}]}
    lag, law, wear = named("lag"), named("tire_law"), named("wear")
    wrong = score(said("found", lag), answer)
    assert not wrong["right"] and wrong["false"] == ["lag"]
    alarm = score(said("found", lag), {"effects": []})
    assert alarm["false_alarm"] and not alarm["right"]
    for verdict, right in (("at floor", True), ("tire law only", True), ("partly", False)):
        assert score(said(verdict), {"effects": []})["right"] is right
    assert score(said("tire law only", law), {"effects": []})["right"]
    beside = score(said("found", law, wear), answer)
    assert beside["right"] and beside["first_right"] and not beside["false"]


def test_what_is_in_no_library_is_found_at_its_place():
    outside = {"effects": [], "outside": {"coordinate": "plank position", "range": [2.0, 2.8]}}
    rest = {"where": [{"coordinate": "plank position", "range": [2.1, 2.6], "share": 0.5}]}
    seen = score(said("none of these", unexplained=rest), outside)
    assert seen["right"] and seen["outside_found"]
    assert not score(said("none of these", unexplained={}), outside)["right"]
    assert not score(said("found", unexplained=rest), outside)["right"]


def test_any_of_several_places_may_be_the_right_one():
    where = {"coordinate": "plank position", "range": [2.0, 2.8]}
    elsewhere, there = ({"coordinate": "plank position", "range": r} for r in ([3, 4], [2.1, 2.6]))
    for places, right in (([elsewhere, there], True), ([elsewhere], False)):
        found = score(
            said("partly", unexplained={"where": places}), {"effects": [], "outside": where}
        )
        assert found["outside_found"] is right


def test_no_seal_is_one_line():
    with pytest.raises(FlatplankError, match="sealed"):
        unseal("/nonexistent")


def test_what_grows_from_run_to_run_is_judged_by_the_runs_that_there_are():
    """13 % less grip over 27 runs is half of that over 14."""
    answer = {"effects": [{"name": "wear", "size": 0.13, "unit": "1", "class": [], "runs": 27}]}
    wear = named("wear", size=0.065, unit="1")
    (points,) = score(said("found", wear, runs=14), answer)["effects"]
    assert points["covered"] and points["error"] == pytest.approx(0.0)
    (points,) = score(said("found", wear, runs=27), answer)["effects"]
    assert not points["covered"] and points["error"] == pytest.approx(-0.5)
    lines = text_of(answer | {"outside": None}, score(said("found", wear, runs=14), answer))
    assert lines[0] == "hidden: wear, 13 % over 27 runs"
    assert lines[1] == "found as wear: 6.5 % over 14 runs (+0 %), its interval covers the truth"
