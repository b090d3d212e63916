# SPDX-License-Identifier: Apache-2.0
"""What people read of a diagnosis: one item per cause, and one list of what to do."""

from __future__ import annotations

from decisions import decision, rival
from shapes import LONG, shape

from flatplank_analysis.discovery import view
from flatplank_analysis.discovery.sources import AT_FLOOR, GROUP, NONE
from flatplank_analysis.discovery.steps import AcceptedEffect
from flatplank_analysis.effects.registry import library
from flatplank_analysis.investigation.notebook import verdict_of
from flatplank_data.wording import one_of

PLAN = {"what": "slip +1 %, 3 x", "separates": [["long"], ["alike"]], "settings": {"kappa": 0.01}}
TEXTS = {"title": "Long", "check": "Look.", "removes": "Mend it."}
GIVEN = decision(shape("long", LONG.form, **TEXTS))
CLASS = AcceptedEffect(GIVEN, rivals=(rival("alike", False),))
ALONE = AcceptedEffect(GIVEN)


def told(*found, plan=None, verdict=GROUP):
    """The list of what to do where these causes were found."""
    causes = [view.Cause.of(f) for f in found]
    return [list(t.lines()) for t in view.tasks(verdict, causes, plan or {}, "mine")]


def test_a_class_is_one_item_with_every_member():
    cause = view.Cause.of(CLASS)
    assert cause.name == "long or alike" and len(cause.members) == 2
    assert cause.sized.endswith(" as alike") and "(90 %:" in cause.sized
    data = view.cause_dict(CLASS)
    assert data["text"]["name"] == "long or alike" and data["class"] == ["alike"]
    assert [m["name"] for m in data["members"]] == ["long", "alike"]
    assert one_of(["a", "b", "c"]) == "a, b or c"


def test_the_run_comes_before_the_checks_and_the_remedy():
    run, check, remedy = told(CLASS, plan=PLAN)
    assert "tells long from alike" in run[0] and check[0].startswith("or check on the machine")
    assert check[1:] == ["  long: Look.", "  alike: "] and remedy[1:] == ["  long: Mend it."]


def test_without_a_run_the_machine_decides():
    check, _ = told(CLASS, plan={"what": "none", "separates": [["long"], ["alike"]]})
    assert "none of the planned runs tells" in check[0]
    (alone, remedy) = told(ALONE)
    assert alone[0] == "check on the machine:"
    assert remedy[0].endswith("and measure the same again: flatplank repair mine AFTER long:")


def test_nothing_to_do_for_the_law_of_the_tire():
    free = AcceptedEffect(decision(shape("free", LONG.form, generic=True)))
    assert told(free) == told(verdict=AT_FLOOR) == []
    assert told(verdict=NONE) == [
        ["describe what is left as an effect file: flatplank propose mine"]
    ]


def test_no_check_on_the_machine_is_a_run_of_the_bench():
    """What a run shows stands in `shown_by`: it must not contradict that no run tells a class."""
    for effect in library().values():
        words = effect.check.lower().replace(",", " ").split()
        assert "runs at" not in effect.check.lower() and "reversed run" not in effect.check.lower()
        assert not {"m/s", "m/s."} & set(words), effect.identifier


def test_an_earlier_diagnosis_is_still_read():
    old = {
        "name": "long", "title": "Long", "class": ["alike"], "size": 1.0, "unit": "N",
        "interval": [0.5, 1.5], "advice": [{"name": "long", "check": "c", "removes": "r"}],
    }  # fmt: skip
    assert view.stored(old)["text"]["name"] == "long or alike"
    assert view.stored(old)["members"] == old["advice"]
    log = {"verdict": {"effects": [old], "verdict": GROUP, "reason": "why"}, "log_e": 9.0}
    assert "long or alike" in verdict_of(log)
